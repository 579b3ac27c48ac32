// pliant serve: a folder of files, such as the page of demos/web.sh, for browsers of this machine.

#include "commands.h"
#include "description/error.h"

#include <httplib.h>

#include <filesystem>
#include <iostream>

namespace app {

int run_serve(const ServeOptions& options) {
    if (!std::filesystem::is_directory(options.folder)) {
        throw demos::Error("there is no folder " + options.folder + "; sh demos/web.sh makes build/web");
    }
    httplib::Server server;
    // Not those of the library, by which two servers share a port unnoticed.
    server.set_socket_options([](socket_t socket) {
        const int yes = 1;
        setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_mount_point("/", options.folder);
    // Browsers run modules only of this type.
    server.set_file_extension_and_mimetype_mapping("mjs", "text/javascript");
    const std::string host = "127.0.0.1";
    const int port = options.port == 0                         ? server.bind_to_any_port(host)
                     : server.bind_to_port(host, options.port) ? options.port
                                                               : -1;
    if (port < 0) {
        throw demos::Error("port " + std::to_string(options.port) + " cannot be used; --port names another");
    }
    std::cout << "http://" << host << ':' << port << '/' << std::endl;
    if (!server.listen_after_bind()) { throw demos::Error("the server has stopped"); }
    return 0;
}

} // namespace app

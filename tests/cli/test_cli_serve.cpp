// pliant serve answers with the files of its folder and with nothing else.

#include "program_run.h"

#include "check.h"

#include <httplib.h>

#include <signal.h>

#include <chrono>
#include <filesystem>
#include <thread>

using cli::scratch;

static int port = 0, process = 0;

static void expect_failure(const std::string& arguments, const std::string& message) {
    const cli::Result result = cli::run("serve " + arguments);
    assert_int_equal(result.status, 1);
    if (result.errors.find(message) == std::string::npos) { fail_msg("'%s'", result.errors.c_str()); }
}

static int start_server(void**) {
    std::filesystem::create_directories(scratch("page"));
    cli::write_file(scratch("page") + "/index.html", "<title>page</title>");
    cli::write_file(scratch("page") + "/engine.mjs", "export const one = 1;");
    cli::write_file(scratch("page") + "/engine.wasm", std::string("\0asm", 4));
    cli::write_file(scratch("secret"), "not served");
    const std::string address = scratch("address"), id = scratch("id");
    cli::run("serve '" + scratch("page") + "' --port 0 >'" + address + "' & echo $! >'" + id + "'");
    process = std::stoi(cli::read_file(id));
    for (int i = 0; i < 1000 && cli::read_file(address).find('\n') == std::string::npos; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    const std::string line = cli::read_file(address), before = "http://127.0.0.1:";
    if (line.rfind(before, 0) != 0) { return -1; }
    port = std::stoi(line.substr(before.size()));
    return 0;
}

static int stop_server(void**) {
    return kill(process, SIGTERM);
}

static void test_serve_files(void**) {
    httplib::Client client("127.0.0.1", port);
    const struct {
        const char *path, *type, *start;
    } files[] = {{"/", "text/html", "<title>page"},
                 {"/engine.mjs", "text/javascript", "export"},
                 {"/engine.wasm", "application/wasm", ""}};
    for (const auto& file : files) {
        const httplib::Result answer = client.Get(file.path);
        assert_true(static_cast<bool>(answer));
        assert_int_equal(answer->status, 200);
        assert_string_equal(answer->get_header_value("Content-Type").c_str(), file.type);
        assert_true(answer->body.rfind(file.start, 0) == 0);
    }
}

static void test_serve_nothing_else(void**) {
    httplib::Client client("127.0.0.1", port);
    for (const char* path : {"/none.html", "/../secret", "/%2e%2e/secret"}) {
        const httplib::Result answer = client.Get(path);
        assert_true(static_cast<bool>(answer));
        assert_int_equal(answer->status, 404);
    }
}

static void test_serve_failures(void**) {
    expect_failure("'" + scratch("nowhere") + "'", "there is no folder ");
    expect_failure("'" + scratch("page") + "' --port " + std::to_string(port), "cannot be used; --port names another");
}

int main() {
    const CMUnitTest tests[] = {cmocka_unit_test(test_serve_files), cmocka_unit_test(test_serve_nothing_else),
                                cmocka_unit_test(test_serve_failures)};
    return cmocka_run_group_tests(tests, start_server, stop_server);
}

// pliant serve where the library for it is missing.

#include "commands.h"
#include "description/error.h"

namespace app {

int run_serve(const ServeOptions&) {
    throw demos::Error("this program was built without a server: install " SERVE_MISSING_PACKAGES
                       ", then configure and build again");
}

} // namespace app

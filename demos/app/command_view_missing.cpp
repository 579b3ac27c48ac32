// pliant view where there are no windows.

#include "commands.h"
#include "description/error.h"

namespace app {

int run_view(const ViewOptions&) {
    throw demos::Error("this program was built without windows: install " VIEW_MISSING_PACKAGES
                       ", then configure and build again");
}

} // namespace app

#ifndef DEMOS_WEB_PAGE_H
#define DEMOS_WEB_PAGE_H

// What the page shows: one scene that runs, its camera, and what the pointer does to it. Functions with C names are
// those that the scripts of the page call.

#include "viewer/orbit.h"
#include "viewer/tools.h"

#include <memory>
#include <string>

namespace web {

struct Page {
    std::unique_ptr<viewer::Session> session;
    viewer::Orbit orbit;
    viewer::DragTool drag;
    viewer::SweptCut cut;
    std::string text; // last answer in words
};

Page& page();

// The only engine that runs.
inline const viewer::Run& run() {
    return page().session->runs().front();
}

// Keeps the words until the next call and returns them.
const char* answer(const std::string& text);

} // namespace web
#endif

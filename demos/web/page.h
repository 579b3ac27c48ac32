#ifndef DEMOS_WEB_PAGE_H
#define DEMOS_WEB_PAGE_H

// What the page shows: one scene that runs on one engine or on two beside each other, its camera, and what the pointer
// does to it. Functions with C names are those that the scripts of the page call.

#include "viewer/orbit.h"
#include "viewer/tools.h"

#include <memory>
#include <string>

namespace web {

struct Page {
    std::unique_ptr<viewer::Session> session;
    viewer::Orbit orbit;
    render::Look look;
    viewer::DragTool drag;
    viewer::SweptCut cut;
    std::string text; // last answer in words
};

Page& page();

// Pliant before btSoftBody.
inline const viewer::Run& run(int index) {
    return page().session->runs().at(static_cast<size_t>(index));
}

// What the cameras of all runs have to show; `extents`: of each.
render::View view_of_all(std::vector<render::Extent>& extents);

// Keeps the words until the next call and returns them.
const char* answer(const std::string& text);

} // namespace web
#endif

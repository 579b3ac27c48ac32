#include "window.h"

#include "description/error.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>

namespace viewer {

static std::string glfw_reason() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text == nullptr ? "no reason is known" : text;
}

// GLFW is never ended: it would unload the system's libraries, with memory that only they can reach.
static void start_glfw() {
    if (glfwInit() == GLFW_FALSE) { throw demos::Error("a window needs a display: " + glfw_reason()); }
}

struct WindowDeleter {
    void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};

struct Interface {
    explicit Interface(GLFWwindow* window) {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr; // leaves no file behind
        ImGui_ImplGlfw_InitForOpenGL(window, true);
        ImGui_ImplOpenGL3_Init("#version 330 core");
    }
    ~Interface() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Interface(const Interface&) = delete;
    Interface& operator=(const Interface&) = delete;
};

struct Window::Parts {
    std::unique_ptr<GLFWwindow, WindowDeleter> window;
    std::unique_ptr<Interface> interface;
    std::vector<Event> events;
    float scale = 1.0f;
};

// ---------------------------------------------------------------------------------------------------- events

static Key key_from_glfw(int key) {
    switch (key) {
    case GLFW_KEY_SPACE:
        return Key::space;
    case GLFW_KEY_PERIOD:
        return Key::period;
    case GLFW_KEY_COMMA:
        return Key::comma;
    case GLFW_KEY_HOME:
        return Key::home;
    case GLFW_KEY_END:
        return Key::end;
    case GLFW_KEY_PAGE_UP:
        return Key::page_up;
    case GLFW_KEY_PAGE_DOWN:
        return Key::page_down;
    case GLFW_KEY_B:
        return Key::b;
    case GLFW_KEY_C:
        return Key::c;
    case GLFW_KEY_F:
        return Key::f;
    case GLFW_KEY_H:
        return Key::h;
    case GLFW_KEY_N:
        return Key::n;
    case GLFW_KEY_P:
        return Key::p;
    case GLFW_KEY_R:
        return Key::r;
    case GLFW_KEY_T:
        return Key::t;
    case GLFW_KEY_W:
        return Key::w;
    case GLFW_KEY_LEFT:
        return Key::left;
    case GLFW_KEY_RIGHT:
        return Key::right;
    case GLFW_KEY_UP:
        return Key::up;
    case GLFW_KEY_DOWN:
        return Key::down;
    case GLFW_KEY_ESCAPE:
        return Key::escape;
    default:
        return Key::none;
    }
}

static Button button_from_glfw(int button) {
    return button == GLFW_MOUSE_BUTTON_LEFT     ? Button::left
           : button == GLFW_MOUSE_BUTTON_MIDDLE ? Button::middle
           : button == GLFW_MOUSE_BUTTON_RIGHT  ? Button::right
                                                : Button::none;
}

// Where the cursor is and which keys go with it.
static Event event_at_cursor(GLFWwindow* window, Event::Kind kind) {
    Event event{kind};
    double x = 0, y = 0;
    int width = 0, height = 0, pixels_wide = 0, pixels_high = 0;
    glfwGetCursorPos(window, &x, &y);
    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &pixels_wide, &pixels_high);
    event.x = static_cast<float>(x * pixels_wide / std::max(width, 1));
    event.y = static_cast<float>(y * pixels_high / std::max(height, 1));
    const auto is_down = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS; };
    event.shift = is_down(GLFW_KEY_LEFT_SHIFT) || is_down(GLFW_KEY_RIGHT_SHIFT);
    event.control = is_down(GLFW_KEY_LEFT_CONTROL) || is_down(GLFW_KEY_RIGHT_CONTROL);
    return event;
}

static std::vector<Event>& events_of(GLFWwindow* window) {
    return *static_cast<std::vector<Event>*>(glfwGetWindowUserPointer(window));
}

// What is let go of always comes through: a tool that has begun must end.
static void on_key(GLFWwindow* window, int key, int, int action, int) {
    Event event = event_at_cursor(window, action == GLFW_RELEASE ? Event::Kind::key_up : Event::Kind::key_down);
    event.key = key_from_glfw(key);
    const bool repeats =
        event.key == Key::period || event.key == Key::comma || event.key == Key::page_up || event.key == Key::page_down;
    const bool is_repeat = action == GLFW_REPEAT && !repeats;
    if (event.key == Key::none || is_repeat) { return; }
    if (action != GLFW_RELEASE && ImGui::GetIO().WantTextInput) { return; }
    events_of(window).push_back(event);
}

static void on_button(GLFWwindow* window, int button, int action, int) {
    if (action == GLFW_PRESS && ImGui::GetIO().WantCaptureMouse) { return; }
    Event event = event_at_cursor(window, action == GLFW_PRESS ? Event::Kind::button_down : Event::Kind::button_up);
    event.button = button_from_glfw(button);
    if (event.button != Button::none) { events_of(window).push_back(event); }
}

static void on_move(GLFWwindow* window, double, double) {
    events_of(window).push_back(event_at_cursor(window, Event::Kind::move));
}

static void on_wheel(GLFWwindow* window, double, double steps) {
    if (ImGui::GetIO().WantCaptureMouse) { return; }
    Event event = event_at_cursor(window, Event::Kind::wheel);
    event.steps = static_cast<float>(steps);
    events_of(window).push_back(event);
}

// ---------------------------------------------------------------------------------------------------- window

Window::Window(const std::string& title, int width, int height) : parts_(std::make_unique<Parts>()) {
    start_glfw();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window == nullptr) { throw demos::Error("a window needs OpenGL 3.3: " + glfw_reason()); }
    parts_->window.reset(window);
    glfwMakeContextCurrent(window);
    glfwSetWindowUserPointer(window, &parts_->events);
    glfwSetKeyCallback(window, on_key);
    glfwSetMouseButtonCallback(window, on_button);
    glfwSetCursorPosCallback(window, on_move);
    glfwSetScrollCallback(window, on_wheel);
    parts_->interface = std::make_unique<Interface>(window); // calls these and its own
    float scale_y = 1.0f;
    glfwGetWindowContentScale(window, &parts_->scale, &scale_y);
    parts_->scale = std::clamp(parts_->scale, 1.0f, 4.0f);
    ImGui::GetStyle().ScaleAllSizes(parts_->scale);
    ImGui::GetStyle().Colors[ImGuiCol_PopupBg].w = 1.0f; // the list of scenes lies over other words
    ImFontConfig font;
    font.SizePixels = 13.0f * parts_->scale;
    ImGui::GetIO().Fonts->AddFontDefault(&font);
}

Window::~Window() = default;

bool Window::is_open() const {
    return glfwWindowShouldClose(parts_->window.get()) == GLFW_FALSE;
}

void Window::close() {
    glfwSetWindowShouldClose(parts_->window.get(), GLFW_TRUE);
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(parts_->window.get(), title.c_str());
}

int Window::width() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(parts_->window.get(), &width, &height);
    return width;
}

int Window::height() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(parts_->window.get(), &width, &height);
    return height;
}

float Window::scale() const {
    return parts_->scale;
}

std::vector<Event> Window::take_events() {
    glfwPollEvents();
    std::vector<Event> taken;
    taken.swap(parts_->events);
    return taken;
}

void Window::begin_panel() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

void Window::draw_panel() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::show() {
    glfwSwapBuffers(parts_->window.get());
}

void Window::set_wait(bool wait) {
    glfwSwapInterval(wait ? 1 : 0);
}

} // namespace viewer

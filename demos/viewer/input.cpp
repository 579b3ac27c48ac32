#include "input.h"

#include <map>

namespace viewer {

Key key_of(const std::string& word) {
    static const std::map<std::string, Key> keys = {{"space", Key::space},
                                                    {".", Key::period},
                                                    {",", Key::comma},
                                                    {"b", Key::b},
                                                    {"c", Key::c},
                                                    {"f", Key::f},
                                                    {"h", Key::h},
                                                    {"n", Key::n},
                                                    {"p", Key::p},
                                                    {"r", Key::r},
                                                    {"t", Key::t},
                                                    {"w", Key::w},
                                                    {"left", Key::left},
                                                    {"right", Key::right},
                                                    {"up", Key::up},
                                                    {"down", Key::down},
                                                    {"home", Key::home},
                                                    {"end", Key::end},
                                                    {"pageup", Key::page_up},
                                                    {"pagedown", Key::page_down},
                                                    {"escape", Key::escape}};
    const auto found = keys.find(word);
    return found == keys.end() ? Key::none : found->second;
}

Button button_of(const std::string& word) {
    return word == "left"     ? Button::left
           : word == "middle" ? Button::middle
           : word == "right"  ? Button::right
                              : Button::none;
}

} // namespace viewer

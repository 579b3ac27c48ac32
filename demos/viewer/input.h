#ifndef DEMOS_VIEWER_INPUT_H
#define DEMOS_VIEWER_INPUT_H

// What comes from mouse and keyboard, or from a script in their place.

#include <string>

namespace viewer {

enum class Key {
    none,
    space,
    period,
    comma,
    b,
    c,
    f,
    h,
    n,
    p,
    r,
    t,
    w,
    left,
    right,
    up,
    down,
    home,
    end,
    page_up,
    page_down,
    escape
};
enum class Button { none, left, middle, right };

struct Event {
    enum class Kind { key_down, key_up, button_down, button_up, move, wheel };
    Kind kind;
    Key key = Key::none;
    Button button = Button::none;
    bool shift = false, control = false; // held down
    float x = 0, y = 0;                  // of the cursor, pixels from the top left corner of the window
    float steps = 0;                     // of the wheel, > 0 away from the user
};

// By the words of scripts: "space", "left", ...; Key::none, Button::none for an unknown word.
Key key_of(const std::string& word);
Button button_of(const std::string& word);

} // namespace viewer
#endif

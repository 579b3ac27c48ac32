#include "script.h"

#include "description/error.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

namespace viewer {

// The words of one line, taken one after the other.
class Words {
public:
    explicit Words(const std::string& line) : stream_(line.substr(0, line.find('#'))) { next(); }

    bool is_empty() const { return present_.empty(); }
    const std::string& present() const { return present_; }
    std::string take(const char* what) {
        if (is_empty()) { throw demos::Error(std::string(what) + " is missing"); }
        const std::string word = present_;
        next();
        return word;
    }
    bool take_if(const char* word) {
        if (present_ != word) { return false; }
        next();
        return true;
    }
    float number(const char* what) {
        const std::string word = take(what);
        size_t used = 0;
        float value = NAN;
        try {
            value = std::stof(word, &used);
        } catch (const std::exception&) { used = 0; }
        if (used != word.size() || !std::isfinite(value)) {
            throw demos::Error(std::string(what) + " is no number: " + word);
        }
        return value;
    }
    int whole_number(const char* what) {
        const float value = number(what);
        if (value < 0.0f || value > 1e6f || value != std::floor(value)) {
            throw demos::Error(std::string(what) + " is no whole number from 0 to 1000000");
        }
        return static_cast<int>(value);
    }

private:
    void next() {
        present_.clear();
        stream_ >> present_;
    }
    std::istringstream stream_;
    std::string present_;
};

static Place read_place(Words& words) {
    Place place;
    if (words.take_if("node")) {
        place.kind = Place::Kind::node;
        place.soft = words.whole_number("the soft body");
        place.node = words.whole_number("the node");
        return place;
    }
    if (words.take_if("by")) { place.kind = Place::Kind::by; }
    place.x = words.number("x");
    place.y = words.number("y");
    return place;
}

static Button read_button(Words& words) {
    const std::string word = words.take("the button");
    const Button button = button_of(word);
    if (button == Button::none) { throw demos::Error("there is no button " + word); }
    return button;
}

static Key read_key(Words& words) {
    const std::string word = words.take("the key");
    const Key key = key_of(word);
    if (key == Key::none) { throw demos::Error("there is no key " + word); }
    return key;
}

static Command read_command(Words& words) {
    Command command;
    command.frame = words.whole_number("the frame");
    const std::string verb = words.take("what happens");
    if (verb == "press") {
        command.kind = Command::Kind::press;
        command.shift = words.take_if("shift");
        command.control = words.take_if("control");
        command.button = read_button(words);
        command.place = read_place(words);
    } else if (verb == "release") {
        command.kind = Command::Kind::release;
        command.button = read_button(words);
    } else if (verb == "move") {
        command.kind = Command::Kind::move;
        command.place = read_place(words);
    } else if (verb == "wheel") {
        command.kind = Command::Kind::wheel;
        command.value = words.number("the number of steps");
        command.place = read_place(words);
    } else if (verb == "key") {
        command.key = read_key(words);
        command.kind = words.take_if("down") ? Command::Kind::key_down
                       : words.take_if("up") ? Command::Kind::key_up
                                             : Command::Kind::key;
    } else if (verb == "set") {
        command.kind = Command::Kind::set;
        command.index = words.whole_number("the control");
        command.value = words.number("the value");
    } else if (verb == "steps") {
        command.kind = Command::Kind::steps;
        command.index = words.whole_number("the number of steps");
    } else if (verb == "go") {
        command.kind = Command::Kind::go;
        command.index = words.whole_number("the frame of the timeline");
    } else if (verb == "scene") {
        command.kind = Command::Kind::scene;
        command.name = words.take("the name of the scene");
    } else if (verb == "report") {
        if (!words.is_empty()) { command.place = read_place(words); }
    } else {
        throw demos::Error("nothing is called " + verb);
    }
    if (!words.is_empty()) { throw demos::Error("there is more than expected: " + words.present()); }
    return command;
}

std::vector<Command> read_script(const std::string& path) {
    errno = 0;
    std::ifstream file(path);
    std::vector<Command> commands;
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
        const std::string source = path + ":" + std::to_string(number);
        try {
            Words words(line);
            if (words.is_empty()) { continue; }
            commands.push_back(read_command(words));
            commands.back().source = source;
            if (commands.size() > 1 && commands[commands.size() - 2].frame > commands.back().frame) {
                throw demos::Error("frames must not go back");
            }
        } catch (const demos::Error& error) { throw demos::Error(source + ": " + error.what()); }
    }
    if (!file.eof()) { throw demos::Error(path + ": " + std::strerror(errno == 0 ? EIO : errno)); }
    return commands;
}

} // namespace viewer

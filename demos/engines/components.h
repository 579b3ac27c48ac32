#ifndef DEMOS_COMPONENTS_H
#define DEMOS_COMPONENTS_H

#include <cstddef>
#include <numeric>
#include <vector>

namespace demos {

// Which members are connected, by union of sets.
class Components {
public:
    explicit Components(int count) : parents_(static_cast<size_t>(count)), count_(count) {
        std::iota(parents_.begin(), parents_.end(), 0);
    }
    void join(int a, int b) {
        const int root_a = root(a), root_b = root(b);
        if (root_a != root_b) {
            parents_[static_cast<size_t>(root_a)] = root_b;
            --count_;
        }
    }
    int count() const { return count_; }

private:
    int root(int member) {
        while (parents_[static_cast<size_t>(member)] != member) {
            int& parent = parents_[static_cast<size_t>(member)];
            parent = parents_[static_cast<size_t>(parent)];
            member = parent;
        }
        return member;
    }
    std::vector<int> parents_;
    int count_;
};

} // namespace demos
#endif

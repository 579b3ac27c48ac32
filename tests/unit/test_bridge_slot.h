// Memory in which one object of Bullet is made after another one, watched where none is.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <cstring>
#include <new>
#include <utility>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TEST_BRIDGE_HAS_ASAN
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define TEST_BRIDGE_HAS_ASAN
#endif
#ifdef TEST_BRIDGE_HAS_ASAN
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(begin, size) ((void)(begin), (void)(size))
#define ASAN_UNPOISON_MEMORY_REGION(begin, size) ((void)(begin), (void)(size))
#endif

namespace bridge_test {

class Slot {
public:
    Slot() { forbid(0); }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;
    ~Slot() {
        clear();
        ASAN_UNPOISON_MEMORY_REGION(memory_, capacity);
    }

    template <typename T, typename... Args> T& make(Args&&... args) {
        static_assert(sizeof(T) <= capacity && alignof(T) <= 64);
        clear();
        ASAN_UNPOISON_MEMORY_REGION(memory_, sizeof(T));
        T* made = ::new (memory_) T(std::forward<Args>(args)...);
        end_ = [](void* memory) { static_cast<T*>(memory)->~T(); };
        used_ = sizeof(T);
        return *made;
    }
    void clear() {
        if (end_ == nullptr) { return; }
        end_(memory_);
        end_ = nullptr;
        used_ = 0;
        forbid(0);
    }
    bool is_empty() const { return end_ == nullptr; }

    /// Nobody has written where no object is.
    bool is_untouched() {
        ASAN_UNPOISON_MEMORY_REGION(memory_ + used_, capacity - used_);
        bool is_so = true;
        for (std::size_t i = used_; i < capacity; ++i) {
            is_so = is_so && memory_[i] == free_byte;
        }
        ASAN_POISON_MEMORY_REGION(memory_ + used_, capacity - used_);
        return is_so;
    }

private:
    static constexpr std::size_t capacity = 2048;
    static constexpr unsigned char free_byte = 0xa5;

    void forbid(std::size_t from) {
        ASAN_UNPOISON_MEMORY_REGION(memory_ + from, capacity - from);
        std::memset(memory_ + from, free_byte, capacity - from);
        ASAN_POISON_MEMORY_REGION(memory_ + from, capacity - from);
    }

    alignas(64) unsigned char memory_[capacity];
    std::size_t used_ = 0;
    void (*end_)(void*) = nullptr;
};

} // namespace bridge_test

// Memory for objects that live as long as one path vertex.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace lacquer {

/// Bump allocator of one thread. Objects are never destroyed, so they must not need it. Blocks are kept
/// across Reset(): after the first few paths nothing is allocated from the heap.
class Arena {
  public:
    static constexpr size_t kBlockSize = size_t(64) * 1024;

    Arena() { blocks_.push_back(std::make_unique<std::byte[]>(kBlockSize)); }
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;

    /// A new T; valid until Reset().
    template <class T, class... Args>
    T* New(Args&&... args) {
        static_assert(std::is_trivially_destructible_v<T>, "nobody calls destructors here");
        static_assert(sizeof(T) <= kBlockSize / 4);
        return new (Allocate(sizeof(T), alignof(T))) T(std::forward<Args>(args)...);
    }
    /// `n` new objects, each T(); valid until Reset(). Errors: std::length_error beyond a quarter of a block.
    template <class T>
    std::span<T> NewArray(size_t n) {
        static_assert(std::is_trivially_destructible_v<T>, "nobody calls destructors here");
        if (n > kBlockSize / 4 / sizeof(T)) throw std::length_error("an array too large for the arena");
        T* const first = static_cast<T*>(Allocate(n * sizeof(T), alignof(T)));
        std::uninitialized_value_construct_n(first, n);
        return {first, n};
    }
    /// Frees all objects at once, keeps the memory.
    void Reset() {
        block_ = 0;
        offset_ = 0;
    }
    size_t BytesReserved() const { return blocks_.size() * kBlockSize; }

  private:
    void* Allocate(size_t size, size_t alignment) {
        uintptr_t base = reinterpret_cast<uintptr_t>(blocks_[block_].get());
        uintptr_t start = (base + offset_ + alignment - 1) & ~(uintptr_t(alignment) - 1);
        if (start + size > base + kBlockSize) {
            if (++block_ == blocks_.size()) blocks_.push_back(std::make_unique<std::byte[]>(kBlockSize));
            base = reinterpret_cast<uintptr_t>(blocks_[block_].get());
            start = (base + alignment - 1) & ~(uintptr_t(alignment) - 1);
        }
        offset_ = start + size - base;
        return reinterpret_cast<void*>(start);
    }
    std::vector<std::unique_ptr<std::byte[]>> blocks_;
    size_t block_ = 0, offset_ = 0;
};

}  // namespace lacquer

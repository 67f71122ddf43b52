// An allocator for pixels: large blocks are put on large pages where the system has them, which
// saves most of the time that fresh memory takes.
#pragma once

#include <cstddef>
#include <new>

namespace lamella {

// Memory of at least this size starts on a large page.
inline constexpr std::size_t kLargePage = std::size_t{1} << 21;
void UseLargePages(void* memory, std::size_t bytes);  // a hint; never fails

template <class T>
struct PixelAllocator {
  using value_type = T;
  PixelAllocator() = default;
  template <class U>
  PixelAllocator(const PixelAllocator<U>&) {}  // NOLINT: allocators convert

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < 2 * kLargePage) return static_cast<T*>(::operator new(bytes));
    void* memory = ::operator new(bytes, std::align_val_t(kLargePage));
    UseLargePages(memory, bytes);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (count * sizeof(T) < 2 * kLargePage) {
      ::operator delete(memory);
    } else {
      ::operator delete(memory, std::align_val_t(kLargePage));
    }
  }
  friend bool operator==(const PixelAllocator&, const PixelAllocator&) { return true; }
};

}  // namespace lamella

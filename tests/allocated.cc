#include "tests/allocated.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include <malloc.h>

namespace {

std::atomic<std::int64_t> now{0}, peak{0}, start{0};

void* Count(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const auto bytes = static_cast<std::int64_t>(malloc_usable_size(memory));
  const std::int64_t all = now.fetch_add(bytes) + bytes;
  std::int64_t most = peak.load();
  while (all > most && !peak.compare_exchange_weak(most, all)) {
  }
  return memory;
}

void Free(void* memory) {
  if (memory == nullptr) return;
  now.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(memory)));
  std::free(memory);  // NOLINT: this is what delete does
}

void* Aligned(std::size_t bytes, std::size_t alignment) {
  return Count(std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment));
}

}  // namespace

// The arrays' forms call these.
void* operator new(std::size_t bytes) {
  return Count(std::malloc(std::max<std::size_t>(bytes, 1)));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return Aligned(std::max<std::size_t>(bytes, 1), static_cast<std::size_t>(alignment));
}
// The library's own calls the first, a sanitizer's does not.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { Free(memory); }
void operator delete(void* memory) noexcept { Free(memory); }
void operator delete(void* memory, std::size_t) noexcept { Free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { Free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { Free(memory); }

namespace lamella {

Allocated::Allocated() {
  start = now.load();
  peak = now.load();
}

double Allocated::PeakBytes() const { return static_cast<double>(peak - start); }

}  // namespace lamella

#include "lightfield/large_pages.h"

#include <memory>

#include <sys/mman.h>

namespace lamella {

void UseLargePages(void* memory, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  std::size_t rest = bytes;
  if (std::align(kLargePage, kLargePage, memory, rest) == nullptr) return;
  madvise(memory, rest / kLargePage * kLargePage, MADV_HUGEPAGE);
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
#endif
}

}  // namespace lamella

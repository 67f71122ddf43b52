#include "lightfield/large_pages.h"

#include <sys/mman.h>

namespace lamella {

void UseLargePages(void* memory, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  madvise(memory, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
#endif
}

}  // namespace lamella

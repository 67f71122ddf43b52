#include "depth/estimate.h"

namespace lamella {}  // namespace lamella

#include "distribute/distribute.h"

namespace lamella {}  // namespace lamella

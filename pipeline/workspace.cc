#include "pipeline/stages.h"
#include "pipeline/workspace.h"

namespace lamella {}  // namespace lamella

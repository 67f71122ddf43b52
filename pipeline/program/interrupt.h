// Ctrl-C and SIGTERM end the program at once. Nothing is lost by that: files appear only when
// whole, programs that were started die with their parent, and the same command continues.
#pragma once

namespace lamella {

// Call once, before any other thread exists: signals then go to a thread of their own.
void EndAtOnceOnInterrupt();

}  // namespace lamella

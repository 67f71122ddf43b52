#include "lightfield/atomic_file.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

TEST(WriteAtomically, LeavesTheOldFileAndNoOtherWhereTheWriterFails) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "a.txt", "old");
  EXPECT_THROW(WriteAtomically(folder / "a.txt",
                               [](const fs::path& temporary) {
                                 std::ofstream(temporary) << "half";
                                 throw InputError("x", "y", "z");
                               }),
               Error);
  EXPECT_EQ(ReadText(folder / "a.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(WriteAtomically, SaysThatAFolderIsMissing) {
  try {
    WriteTextAtomically(ScratchFolder() / "no" / "a.txt", "text");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kMachine);
    EXPECT_NE(std::string(error.what()).find("a.txt"), std::string::npos);
  }
}

TEST(Hash, GivesThePublishedDigests) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "abc", "abc");
  EXPECT_EQ(Sha256OfFile(folder / "abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2
  EXPECT_EQ(ContentHash(""), "99aa06d3014798d86001c324468d497f");  // xxHash's own test vector
  EXPECT_EQ(ContentHashOfFile(folder / "abc"), ContentHash("abc"));
}

}  // namespace
}  // namespace lamella

// Files that appear only when whole: written beside their place, synced, renamed.
#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace lamella {

// Calls `write` with a temporary path in the same folder and with the same extension
// ("NAME.partial.EXT"), then renames it to `path`. On any failure the temporary file is removed
// and the error goes on; a full disk or a missing permission becomes a MachineError naming `path`.
void WriteAtomically(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path& temporary)>& write);
// The same in steps: what is not committed is removed.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::filesystem::path& temporary() const { return temporary_; }
  void Commit();
  // What an error that was met in writing means, thrown.
  [[noreturn]] void Fail(const std::exception& error) const;

 private:
  std::filesystem::path path_, temporary_;
};
void WriteTextAtomically(const std::filesystem::path& path, std::string_view text);

// UsageError or MachineError where a file can't be written: said before the minutes that its
// content takes.
void CheckWritable(const std::filesystem::path& path);

// The whole file; InputError where it can't be read.
std::string ReadText(const std::filesystem::path& path);

// Creates the folder and its parents; MachineError where that is not possible.
void CreateFolder(const std::filesystem::path& path);

}  // namespace lamella

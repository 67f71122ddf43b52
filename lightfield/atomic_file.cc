#include "lightfield/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "lightfield/error.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void ThrowUnwritable(const fs::path& path, const std::string& reason) {
  throw MachineError(path.string(), "can't be written (" + reason + ")",
                     "check permissions and free space, then run the same command again");
}

// The reason for a failed write that the writer itself could not tell.
std::string WriteFailureReason(const fs::path& temporary) {
  std::error_code error;
  const fs::path folder = temporary.parent_path().empty() ? "." : temporary.parent_path();
  const fs::space_info space = fs::space(folder, error);
  if (!error && space.available < (1U << 16)) return "no space left on the disk";
  if (access(folder.c_str(), W_OK) != 0) return std::strerror(errno);
  return "";
}

void Sync(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) ThrowUnwritable(path, std::strerror(errno));
  const bool synced = fsync(file) == 0;
  const int reason = errno;
  close(file);
  if (!synced) ThrowUnwritable(path, std::strerror(reason));
}

}  // namespace

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)), temporary_(path_) {
  temporary_.replace_filename(path_.stem().string() + ".partial" + path_.extension().string());
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void AtomicFile::Commit() {
  Sync(temporary_);
  fs::rename(temporary_, path_);
}

void AtomicFile::Fail(const std::exception& error) const {
  const std::string reason = WriteFailureReason(temporary_);
  const Error* ours = dynamic_cast<const Error*>(&error);
  if (ours != nullptr && (ours->code() == ExitCode::kMachine || reason.empty())) throw *ours;
  ThrowUnwritable(path_, reason.empty() ? error.what() : reason);
}

void WriteAtomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  AtomicFile file(path);
  try {
    write(file.temporary());
    file.Commit();
  } catch (const std::exception& error) {
    file.Fail(error);
  }
}

void WriteTextAtomically(const fs::path& path, std::string_view text) {
  WriteAtomically(path, [&](const fs::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    file.close();
    if (!file) ThrowUnwritable(path, std::strerror(errno));
  });
}

void CheckWritable(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw UsageError(path.string(), "is a folder", "give the name of a file");
  }
  const AtomicFile probe(path);
  if (std::ofstream(probe.temporary())) return;
  throw MachineError(path.string(), "can't be written",
                     "give a file in a folder that exists and that you may write to");
}

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    if (std::error_code error; fs::exists(path, error) && fs::file_size(path, error) == 0)
      return "";
    throw InputError(path.string(), "can't be read", "check that it exists and is a readable file");
  }
  return text.str();
}

void CreateFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) ThrowUnwritable(path, error.message());
}

}  // namespace lamella

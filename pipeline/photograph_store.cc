#include "pipeline/photograph_store.h"

#include <utility>

#include "lightfield/image_io.h"

namespace lamella {
namespace {

// One name for a file, however the workspace was named.
std::filesystem::path KeyOf(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).lexically_normal();
}

}  // namespace

void PhotographStore::Add(const std::filesystem::path& file, Image<Rgb8> codes) {
  const std::size_t bytes = codes.size() * sizeof(Rgb8);
  const std::lock_guard lock(mutex_);
  if (bytes > most_bytes_ - bytes_) return;
  if (photographs_.emplace(KeyOf(file), std::move(codes)).second) bytes_ += bytes;
}

// What is in the map stays where it is.
const Image<Rgb8>* PhotographStore::Find(const std::filesystem::path& file) const {
  const std::lock_guard lock(mutex_);
  const auto found = photographs_.find(KeyOf(file));
  return found == photographs_.end() ? nullptr : &found->second;
}

Image<Rgb8> PhotographStore::Codes(const std::filesystem::path& file) const {
  const Image<Rgb8>* codes = Find(file);
  return codes ? codes->Clone() : ReadSrgb8(file);
}

Image<Rgb> PhotographStore::Linear(const std::filesystem::path& file) const {
  const Image<Rgb8>* codes = Find(file);
  return codes ? DecodeSrgb8(codes->span()) : ReadImage(file);
}

}  // namespace lamella

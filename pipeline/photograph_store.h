// Decoded photographs that one stage of a run hands to the next.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>

#include "lightfield/image.h"

namespace lamella {

// Decoding takes longer than most of what is done with a pixel: what a stage has just written need
// not be read from its file again. Holds sRGB codes and only as many as it may; every other
// photograph is read from its file, with the same result. Safe to use from many threads.
class PhotographStore {
 public:
  explicit PhotographStore(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  // Keeps what fits: the first ones stay.
  void Add(const std::filesystem::path& file, Image<Rgb8> codes);
  Image<Rgb8> Codes(const std::filesystem::path& file) const;  // as ReadSrgb8
  Image<Rgb> Linear(const std::filesystem::path& file) const;  // as ReadImage

 private:
  const Image<Rgb8>* Find(const std::filesystem::path& file) const;

  std::size_t most_bytes_, bytes_ = 0;
  mutable std::mutex mutex_;
  std::map<std::filesystem::path, Image<Rgb8>> photographs_;
};

}  // namespace lamella

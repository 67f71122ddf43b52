// Portable float maps: raw floats below a header of text.
#include <bit>
#include <cstdint>
#include <sstream>
#include <string>

#include "lightfield/atomic_file.h"
#include "lightfield/image_file-inl.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace fs = std::filesystem;

Image<float> ReadPfm(const fs::path& path) {
  std::istringstream file(ReadText(path));
  std::string magic;
  int width = 0, height = 0;
  double scale = 0;
  if (!(file >> magic >> width >> height >> scale) || magic != "Pf" || width < 1 || height < 1 ||
      scale == 0 || width > (1 << 20) || height > (1 << 20)) {
    throw UnreadableImage(path, "no one-channel PFM");
  }
  file.get();  // the one blank after the header
  const auto pixels = static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height);
  if (fs::file_size(path) < pixels * sizeof(float))
    throw UnreadableImage(path, "the PFM is truncated");
  Image<float> image(width, height);
  for (int y = height - 1; y >= 0; --y) {  // rows are stored bottom to top
    file.read(reinterpret_cast<char*>(image.row(y)),
              static_cast<std::streamsize>(sizeof(float)) * width);
  }
  if (!file) throw UnreadableImage(path, "the PFM is truncated");
  const bool little = scale < 0;
  if (little != (std::endian::native == std::endian::little)) {
    for (std::size_t i = 0; i < image.size(); ++i) {
      const auto bits = std::bit_cast<std::uint32_t>(image.data()[i]);
      image.data()[i] = std::bit_cast<float>(__builtin_bswap32(bits));
    }
  }
  return image;
}

}  // namespace lamella

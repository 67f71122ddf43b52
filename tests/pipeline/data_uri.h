// Pictures of a page, as a browser reads them.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "lightfield/image.h"
#include "lightfield/image_io.h"

namespace lamella {

// Of "data:image/png;base64,..." or jpeg, by way of a file in `folder`.
inline Image<Rgb8> PictureOfUri(const std::string& uri, const std::filesystem::path& folder) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned word = 0;
  int bits = 0;
  for (std::size_t i = uri.find(',') + 1; i < uri.size() && uri[i] != '='; ++i) {
    word = word << 6U | static_cast<unsigned>(digits.find(uri[i]));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(word >> static_cast<unsigned>(bits) & 255U);
  }
  const std::filesystem::path file =
      folder / (uri.starts_with("data:image/png") ? "picture.png" : "picture.jpg");
  std::ofstream(file, std::ios::binary) << bytes;
  return ReadSrgb8(file);
}

}  // namespace lamella

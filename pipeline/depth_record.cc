#include "pipeline/depth_record.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr const char* kDepthChannel = "Z";
constexpr const char* kConfidenceChannel = "confidence";

template <class UInt>
void AppendLittleEndian(std::string& bytes, UInt value) {
  for (std::size_t i = 0; i < sizeof(UInt); ++i) {
    bytes.push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
  }
}

}  // namespace

void SaveDepthMap(const fs::path& path, const DepthMap& map) {
  std::vector<Channel> channels;
  channels.push_back({kDepthChannel, map.depth.Clone()});
  channels.push_back({kConfidenceChannel, map.confidence.Clone()});
  // Packing takes an eighth off estimated depth, and longer to undo than to read it.
  WriteExr(path, channels, ExrType::kFloat, ExrCompression::kNone);
}

DepthMap LoadDepthMap(const fs::path& path) {
  std::vector<Channel> channels = ReadExr(path);
  DepthMap map{TakeChannel(channels, kDepthChannel, path),
               TakeChannel(channels, kConfidenceChannel, path)};
  for (std::size_t i = 0; i < map.depth.size(); ++i) {
    const float depth = map.depth.data()[i], confidence = map.confidence.data()[i];
    if (!(depth >= 0) || !(confidence >= 0 && confidence <= 1)) {
      throw InputError(path.string(),
                       fmt::format("pixel {},{} has depth {} and confidence {}",
                                   static_cast<int>(i) % map.depth.width(),
                                   static_cast<int>(i) / map.depth.width(), depth, confidence),
                       "run `lamella depth` again");
    }
  }
  return map;
}

Image<float> LoadDepth(const fs::path& path) {
  std::vector<Channel> channels = ReadExr(path);
  Image<float> depth = TakeChannel(channels, kDepthChannel, path);
  const float* begin = depth.data();
  if (!std::all_of(begin, begin + depth.size(), [](float z) { return z >= 0; })) {
    throw InputError(path.string(), "has negative depths or such as are no numbers",
                     "give depth along the optical axis, 0 where it is unknown");
  }
  return depth;
}

void SavePoints(const fs::path& path, const std::vector<ColoredPoint>& points) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property double x\nproperty double y\nproperty double z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  for (const ColoredPoint& point : points) {
    for (int i = 0; i < 3; ++i) {
      AppendLittleEndian(bytes, std::bit_cast<std::uint64_t>(point.position[i]));
    }
    for (const std::uint8_t code : {point.color.r, point.color.g, point.color.b}) {
      AppendLittleEndian(bytes, code);
    }
  }
  WriteTextAtomically(path, bytes);
}

}  // namespace lamella

#include "pipeline/varifocal_frames.h"

#include <fmt/format.h>

#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/json_file.h"
#include "pipeline/slot_frames.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

void WriteAll(const fs::path& folder, const std::vector<Image<Rgb8>>& frames,
              const std::vector<std::string>& files) {
  ParallelForEach(0, static_cast<std::int64_t>(frames.size()), [&](std::int64_t i) {
    const auto stroke = static_cast<std::size_t>(i);
    WriteCodes8(folder / files[stroke], frames[stroke].span(), 95, PngCoding::kFast);
  });
}

std::vector<std::string> Numbered(const char* name, std::size_t count) {
  std::vector<std::string> files;
  for (std::size_t i = 0; i < count; ++i) files.push_back(fmt::format("{}_{:02}.png", name, i));
  return files;
}

// The frames in which plane k shows the number k, one for every direction of the mirror.
std::vector<Image<Rgb8>> NumeralFrames(const Display& display, const PlanePacking& packing) {
  BitPlanes bits{static_cast<int>(display.layers.size()), {}};
  for (int stroke = 0; stroke < (packing.there_and_back ? 2 : 1); ++stroke) {
    bits.strokes.push_back(NumeralPlanes(display));
  }
  return PackedFrames(bits, display, packing);
}

}  // namespace

StrokeFrames WriteStrokeFrames(const fs::path& folder, const LayerImages& layers,
                               const Display& display, const OneBitOptions& options,
                               const PlanePacking& packing, std::vector<std::string>& numerals) {
  const std::vector<Image<Rgb8>> frames =
      PackedFrames(OneBitPlanes(layers, display, options), display, packing);
  StrokeFrames written{Numbered("stroke", frames.size()), static_cast<int>(display.layers.size()),
                       packing};
  WriteAll(folder, frames, written.files);
  numerals.clear();
  if (!NumeralsFit(display)) return written;
  const std::vector<Image<Rgb8>> numbers = NumeralFrames(display, packing);
  numerals = Numbered("numerals", numbers.size());
  WriteAll(folder, numbers, numerals);
  return written;
}

std::optional<StrokeFrames> LoadStrokeFrames(const fs::path& folder, const Display& display) {
  const JsonObject json(folder / "frames.json");
  if (!json.Has("strokes")) return {};
  StrokeFrames frames;
  for (const JsonObject& stroke : json.Objects("strokes")) {
    frames.files.push_back(stroke.Text("file"));
  }
  const JsonObject packing = json.Object("packing");
  frames.planes = static_cast<int>(display.layers.size());
  frames.packing = {ChannelOrderOf(packing.Text("channels")), BitOrderOf(packing.Text("bits")),
                    packing.Truth("there_and_back")};
  return frames;
}

std::vector<Image<float>> ReadStrokeFrames(const fs::path& folder, const StrokeFrames& frames,
                                           const Display& display) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  std::vector<Image<float>> mean;
  for (int plane = 0; plane < frames.planes; ++plane) mean.emplace_back(columns, rows);
  const float weight = 1.0F / static_cast<float>(frames.files.size());
  for (std::size_t stroke = 0; stroke < frames.files.size(); ++stroke) {
    const Image<Rgb8> codes = ReadFrame(folder / frames.files[stroke], display);
    const Image<std::uint32_t> bits = EmitterBits(
        UnpackedFrame(codes.span(), frames.planes, static_cast<int>(stroke), frames.packing),
        display);
    ParallelForEach(0, rows, [&](std::int64_t y) {
      const int row = static_cast<int>(y);
      for (int x = 0; x < columns; ++x) {
        for (std::size_t plane = 0; plane < mean.size(); ++plane) {
          if ((bits(x, row) >> plane & 1U) != 0) mean[plane](x, row) += weight;
        }
      }
    });
  }
  return mean;
}

}  // namespace lamella

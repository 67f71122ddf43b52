#include "pipeline/varifocal_frames.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "distribute/strips.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/json_file.h"
#include "pipeline/slot_frames.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// A frame a stroke, packed by the thread that writes it.
void WriteFrames(const fs::path& folder, const BitPlanes& bits, const Display& display,
                 const PlanePacking& packing, const std::vector<std::string>& files) {
  ParallelForEach(0, std::ssize(files), [&](std::int64_t i) {
    const Image<Rgb8> frame = PackedStroke(bits, static_cast<int>(i), display, packing);
    WriteCodes8(folder / files[static_cast<std::size_t>(i)], frame.span(), 95, PngCoding::kFast);
  });
}

std::vector<std::string> Numbered(const char* name, std::size_t count) {
  std::vector<std::string> files;
  for (std::size_t i = 0; i < count; ++i) files.push_back(fmt::format("{}_{:02}.png", name, i));
  return files;
}

// Plane k shows the number k, in one stroke for every direction of the mirror.
BitPlanes Numerals(const Display& display, const PlanePacking& packing) {
  BitPlanes bits{static_cast<int>(display.layers.size()), {}};
  for (int stroke = 0; stroke < (packing.there_and_back ? 2 : 1); ++stroke) {
    bits.strokes.push_back(NumeralPlanes(display));
  }
  return bits;
}

}  // namespace

std::vector<Image<float>> ReadGrey(const OpenEmitters& emitters, const Display& display) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  std::vector<Image<float>> grey(display.layers.size());
  ParallelForEach(0, std::ssize(grey), [&](std::int64_t plane) {
    Image<float>& of_plane = grey[static_cast<std::size_t>(plane)];
    of_plane = Image<float>(columns, rows);
    const ReadEmitterRows read = emitters(static_cast<int>(plane), 0);  // lenslets have one slot
    for (int first = 0; first < rows; first += kBlockRows) {
      const Image<float> block = GreyOf(read(first, std::min(first + kBlockRows, rows)));
      std::copy_n(block.data(), block.size(), of_plane.row(first));
    }
  });
  return grey;
}

StrokeFrames WriteStrokeFrames(const fs::path& folder, std::vector<Image<float>> grey,
                               const Display& display, const OneBitOptions& options,
                               const PlanePacking& packing, std::vector<std::string>& numerals) {
  CheckStrokes(options.strokes, packing);
  const BitPlanes bits = OneBitPlanes(grey, display, options);
  grey.clear();
  StrokeFrames written{Numbered("stroke", bits.strokes.size()), bits.planes, packing};
  WriteFrames(folder, bits, display, packing, written.files);
  numerals.clear();
  if (!NumeralsFit(display)) return written;
  const BitPlanes numbers = Numerals(display, packing);
  numerals = Numbered("numerals", numbers.strokes.size());
  WriteFrames(folder, numbers, display, packing, numerals);
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

std::vector<Image<std::uint16_t>> CountStrokes(const fs::path& folder, const StrokeFrames& frames,
                                               const Display& display) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  std::vector<Image<std::uint16_t>> counts;
  for (int plane = 0; plane < frames.planes; ++plane) counts.emplace_back(columns, rows);
  for (std::size_t stroke = 0; stroke < frames.files.size(); ++stroke) {
    const Image<Rgb8> codes = ReadFrame(folder / frames.files[stroke], display);
    const Image<std::uint32_t> bits = EmitterBits(
        UnpackedFrame(codes.span(), frames.planes, static_cast<int>(stroke), frames.packing),
        display);
    ParallelForEach(0, rows, [&](std::int64_t y) {
      const int row = static_cast<int>(y);
      for (int x = 0; x < columns; ++x) {
        for (std::size_t plane = 0; plane < counts.size(); ++plane) {
          counts[plane](x, row) += static_cast<std::uint16_t>(bits(x, row) >> plane & 1U);
        }
      }
    });
  }
  return counts;
}

std::vector<float> SharesOfStrokes(const StrokeFrames& frames) {
  const float weight = 1.0F / static_cast<float>(frames.files.size());
  std::vector<float> shares(frames.files.size() + 1);
  for (std::size_t count = 1; count < shares.size(); ++count) {
    shares[count] = shares[count - 1] + weight;
  }
  return shares;
}

}  // namespace lamella

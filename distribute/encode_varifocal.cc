#include "distribute/encode_varifocal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "distribute/direction_lattice.h"
#include "distribute/panel_pixels-inl.h"
#include "distribute/stroke_order.h"
#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/parallel.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

constexpr std::array<std::string_view, 6> kChannelOrders{"RGB", "RBG", "GRB", "GBR", "BRG", "BGR"};
constexpr std::array<std::string_view, 2> kBitOrders{"lsb-first", "msb-first"};

template <class Order, std::size_t kCount>
Order OrderOf(std::string_view name, const std::array<std::string_view, kCount>& names,
              const std::string& what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Order>(found - names.begin());
  throw UsageError(what, "there is no \"" + std::string(name) + "\"",
                   "did you mean \"" + NearestName(name, {names.begin(), names.end()}) + "\"?");
}

// The order of a byte's bits turned round, in each byte.
std::uint32_t MirrorBytes(std::uint32_t bits) {
  bits = (bits >> 1U & 0x55555555U) | (bits & 0x55555555U) << 1U;
  bits = (bits >> 2U & 0x33333333U) | (bits & 0x33333333U) << 2U;
  return (bits >> 4U & 0x0F0F0F0FU) | (bits & 0x0F0F0F0FU) << 4U;
}

// Bits by exposure from bits by plane, and back: bit i of one is bit order[i] of the other.
std::uint32_t Turn(std::uint32_t bits, int planes) {
  std::uint32_t turned = 0;
  for (int i = 0; i < planes; ++i) turned |= (bits >> unsigned(i) & 1U) << unsigned(planes - 1 - i);
  return turned;
}

bool Falls(int planes, int stroke, const PlanePacking& packing) {
  return packing.there_and_back && StrokeOrder(planes, stroke).front() != 0;
}

void CheckPlanes(int planes) {
  if (planes >= 1 && planes <= kMaxBitPlanes) return;
  throw UsageError("planes", std::to_string(planes) + " planes of one bit in a frame",
                   "use 1 to " + std::to_string(kMaxBitPlanes));
}

// Ten numerals of 3 x 5 squares, rows from the top, three bits each with the left one first.
constexpr std::array<std::array<std::uint8_t, 5>, 10> kNumerals{{{7, 5, 5, 5, 7},
                                                                 {2, 6, 2, 2, 7},
                                                                 {7, 1, 7, 4, 7},
                                                                 {7, 1, 7, 1, 7},
                                                                 {5, 5, 7, 1, 1},
                                                                 {7, 4, 7, 1, 7},
                                                                 {7, 4, 7, 5, 7},
                                                                 {7, 1, 1, 1, 1},
                                                                 {7, 5, 7, 5, 7},
                                                                 {7, 5, 7, 1, 7}}};
constexpr int kNumberSquares = 7;  // across two numerals and the gap between
constexpr int kNumeralRows = 5;

// Whether square (column, row) of a number of one or two digits is lit.
bool NumberSquare(int number, int column, int row) {
  const std::string digits = std::to_string(number);
  const int digit = column / 4, inside = column % 4;
  if (inside == 3 || digit >= static_cast<int>(digits.size())) return false;
  const auto& rows = kNumerals.at(static_cast<std::size_t>(digits[std::size_t(digit)] - '0'));
  return (rows.at(static_cast<std::size_t>(row)) >> unsigned(2 - inside) & 1U) != 0;
}

// Where numbers stand: cells in reading order, as square as they come, and in each of them the
// number's squares, with a square of margin around.
struct NumeralCells {
  int columns = 1;
  double width = 0, height = 0, square = 0;  // emitters

  NumeralCells(int planes, int panel_columns, int panel_rows) {
    const double aspect = static_cast<double>(panel_columns) / panel_rows;
    columns = std::clamp(static_cast<int>(std::round(std::sqrt(planes * aspect))), 1, planes);
    const int rows = (planes + columns - 1) / columns;
    width = static_cast<double>(panel_columns) / columns;
    height = static_cast<double>(panel_rows) / rows;
    square = std::min(width / (kNumberSquares + 2), height / (kNumeralRows + 2));
  }

  bool Lit(int plane, double x, double y) const {
    const int cell_column = plane % columns, cell_row = plane / columns;
    const double column = std::floor((x - cell_column * width) / square) - 1;
    const double row = std::floor((y - cell_row * height) / square) - 1;
    return column >= 0 && column < kNumberSquares && row >= 0 && row < kNumeralRows &&
           NumberSquare(plane, static_cast<int>(column), static_cast<int>(row));
  }
};

}  // namespace

std::vector<std::string> ChannelOrderNames() {
  return {kChannelOrders.begin(), kChannelOrders.end()};
}
std::vector<std::string> BitOrderNames() { return {kBitOrders.begin(), kBitOrders.end()}; }

std::string NameOf(ChannelOrder order) {
  return std::string(kChannelOrders.at(static_cast<std::size_t>(order)));
}
std::string NameOf(BitOrder order) {
  return std::string(kBitOrders.at(static_cast<std::size_t>(order)));
}

ChannelOrder ChannelOrderOf(std::string_view name) {
  return OrderOf<ChannelOrder>(name, kChannelOrders, "channel order");
}
BitOrder BitOrderOf(std::string_view name) {
  return OrderOf<BitOrder>(name, kBitOrders, "bit order");
}

Image<std::uint32_t> PanelBits(const Image<std::uint32_t>& emitters, const Display& display) {
  return PanelFromEmitters<std::uint32_t>(display, display.layers.at(0), emitters.height(),
                                          [&](int x, int y) { return emitters(x, y); });
}

Image<std::uint32_t> EmitterBits(const Image<std::uint32_t>& panel, const Display& display) {
  return EmittersFromPanel(display, display.layers.at(0), panel.span());
}

Image<Rgb8> PackedFrame(const Image<std::uint32_t>& bits, int planes, int stroke,
                        const PlanePacking& packing) {
  CheckPlanes(planes);
  const bool falls = Falls(planes, stroke, packing);
  const std::string channels = NameOf(packing.channels);
  Image<Rgb8> frame(bits.width(), bits.height());
  ParallelFor(0, bits.height(), 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      for (int x = 0; x < bits.width(); ++x) {
        std::uint32_t word = falls ? Turn(bits(x, y), planes) : bits(x, y);
        if (packing.bits == BitOrder::kMsbFirst) word = MirrorBytes(word);
        const auto [r, g, b] = PackBitPlanes(word, channels);
        frame(x, y) = {r, g, b};
      }
    }
  });
  return frame;
}

Image<std::uint32_t> UnpackedFrame(ImageSpan<const Rgb8> frame, int planes, int stroke,
                                   const PlanePacking& packing) {
  CheckPlanes(planes);
  const bool falls = Falls(planes, stroke, packing);
  const std::string channels = NameOf(packing.channels);
  Image<std::uint32_t> bits(frame.width, frame.height);
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      const Rgb8& codes = frame(x, y);
      std::uint32_t word = 0;
      for (unsigned part = 0; part < 3; ++part) {
        const char channel = channels[part];
        const std::uint32_t code = channel == 'R' ? codes.r : channel == 'G' ? codes.g : codes.b;
        word |= code << (8 * part);
      }
      if (packing.bits == BitOrder::kMsbFirst) word = MirrorBytes(word);
      if (word >> static_cast<unsigned>(planes) != 0) {
        throw InputError("a frame of " + std::to_string(planes) + " planes",
                         "it has bits of other planes",
                         "unpack it with the channel and bit order it was packed with");
      }
      bits(x, y) = falls ? Turn(word, planes) : word;
    }
  }
  return bits;
}

void CheckStrokes(int strokes, const PlanePacking& packing) {
  if (!packing.there_and_back || strokes % 2 == 0) return;
  throw UsageError("strokes",
                   std::to_string(strokes) + " of them cannot be repeated there and back",
                   "use an even number");
}

Image<Rgb8> PackedStroke(const BitPlanes& bits, int stroke, const Display& display,
                         const PlanePacking& packing) {
  return PackedFrame(PanelBits(bits.strokes.at(static_cast<std::size_t>(stroke)), display),
                     bits.planes, stroke, packing);
}

bool NumeralsFit(const Display& display) {
  const NumeralCells cells(static_cast<int>(display.layers.size()), display.emitter_columns(),
                           display.emitter_rows());
  return std::all_of(display.layers.begin(), display.layers.end(), [&](const Layer& layer) {
    const LensletArray* lenses = std::get_if<LensletArray>(&layer.optics);
    return lenses == nullptr || cells.square >= lenses->pitch_px;
  });
}

Image<std::uint32_t> NumeralPlanes(const Display& display) {
  const int planes = static_cast<int>(display.layers.size());
  CheckPlanes(planes);
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  if (!NumeralsFit(display)) {
    throw UsageError(display.name,
                     "too few lenses for the numbers of " + std::to_string(planes) + " planes",
                     "use a larger panel or fewer planes");
  }
  const NumeralCells cells(planes, columns, rows);
  Image<std::uint32_t> bits(columns, rows);
  const auto lattices = DirectionsOfAll(display);
  for (int plane = 0; plane < planes; ++plane) {
    const DirectionLattice& lattice = *lattices[static_cast<std::size_t>(plane)];
    // A lens is lit in all directions or in none, so that all views show the whole number.
    for (const Image<int>& emitters : lattice.emitters) {
      for (int y = 0; y < lattice.rows; ++y) {
        for (int x = 0; x < lattice.columns; ++x) {
          const Lens lens = LensOf(lattice.lenses, lattice.first_row + y, lattice.first_column + x);
          const int at = emitters(x, y);
          if (at != DirectionLattice::kNone && cells.Lit(plane, lens.x_px, lens.y_px)) {
            bits.data()[at] |= 1U << static_cast<unsigned>(plane);
          }
        }
      }
    }
  }
  return bits;
}

}  // namespace lamella

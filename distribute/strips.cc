#include "distribute/strips.h"

#include <algorithm>
#include <cmath>

#include "distribute/accumulate.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Of a beam along one axis, with its overlaps and the room that their lists have to grow.
constexpr double kBeamBytes = 128, kOverlapBytes = 96;
// Of an emitter's own beam along both axes, where layers' gaps are alike.
constexpr double kOwnBeamBytes = 288;
// Lower strips would spend most of their time on the rows around them.
constexpr int kLeastRows = 4 * kBlockRows;

int Widest(const std::vector<SampleRange>& ranges) {
  int widest = 0;
  for (const SampleRange& range : ranges) widest = std::max(widest, range.size());
  return widest;
}

// Nodes that a beam reaches along an axis: it is as wide as its opening and its emitter.
double NodesOfBeam(const Display& display, const Layer& layer, const NodeAxis& axis) {
  const double step = DirectionStepMm(display, layer) / layer.seen_d0_mm() *
                      (display.shear ? display.viewing_distance_mm : 1.0);
  // Of the directions of an element, those that one emitter's beam covers.
  const double directions =
      static_cast<double>(DirectionsPerAxis(layer)) / std::max(1, SlotsPerAxis(layer)) + 1;
  return std::min(static_cast<double>(axis.count), directions * step / axis.step + 2);
}

double BytesOfSums(const Display& display, int rows) {
  double bytes = 0;
  for (const Layer& layer : display.layers) {
    const double k = SlotsPerAxis(layer);
    bytes += k * k * EmitterColumns(display, layer) * rows * sizeof(Light);
  }
  return bytes;
}

// Of the columns (by row where every row has its own), the strip's rows and, to know which nodes
// there are, all rows.
double BytesOfBeams(const Display& display, const NodeLattice& nodes, int rows) {
  double bytes = 0;
  for (const Layer& layer : display.layers) {
    const double k = SlotsPerAxis(layer);
    const double along_x = kBeamBytes + kOverlapBytes * NodesOfBeam(display, layer, nodes.x);
    const double along_y = kBeamBytes + kOverlapBytes * NodesOfBeam(display, layer, nodes.y);
    const double families = HasRowFamilies(layer) ? rows : 2;
    bytes += k * EmitterColumns(display, layer) * families * along_x;
    bytes += k * (rows * along_y + display.emitter_rows() * kBeamBytes);
  }
  return bytes;
}

double BytesOfOwnBeams(const Display& display, int rows) {
  double bytes = 0;
  for (const Layer& layer : display.layers) {
    const double k = SlotsPerAxis(layer);
    bytes += kOwnBeamBytes * k * k * EmitterColumns(display, layer) * rows;
  }
  return bytes;
}

}  // namespace

double BytesOfStrips(const Display& display, const NodeLattice& nodes, const RaySource& source,
                     bool own_beams, int rows) {
  const int width = Widest(nodes.samples_x);
  // Beams of a strip's rows reach a little beyond it, by their width.
  int elements = 0, columns = 0;
  for (const Layer& layer : display.layers) {
    elements = std::max(elements, DirectionsPerAxis(layer));
    columns = std::max(columns, EmitterColumns(display, layer));
  }
  const double per_row = display.emitter_pitch_mm() / nodes.sample_y.size_mm;
  const int reach = static_cast<int>(std::ceil(per_row * (elements + 2)));
  const int height = std::min(static_cast<int>(std::ceil(per_row * rows)) + reach,
                              std::max(Widest(nodes.samples_y), 1));
  const double samples = static_cast<double>(width) * height * sizeof(RaySample);
  // A thread filters a few rows of samples, and gives away a block of emitters in two forms.
  const double of_thread = kNodesAtATime * 2.0 * reach * width * sizeof(Light) +
                           2.0 * kBlockRows * columns * (sizeof(Rgb) + sizeof(float));
  const double beams =
      own_beams ? BytesOfOwnBeams(display, rows) : BytesOfBeams(display, nodes, rows);
  return BytesOfSums(display, rows) + beams + kNodesAtATime * samples +
         source.QueryBytes(width, height) + NumThreads() * of_thread;
}

std::vector<Strip> StripsOf(const Display& display, const NodeLattice& nodes,
                            const RaySource& source, bool own_beams, double bytes) {
  const int rows = display.emitter_rows();
  int count = 1, step = rows;
  while (step > kLeastRows && BytesOfStrips(display, nodes, source, own_beams, step) > bytes) {
    ++count;
    step = ((rows + count - 1) / count + kBlockRows - 1) / kBlockRows * kBlockRows;
  }
  std::vector<Strip> strips;
  for (int row = 0; row < rows; row += step) strips.push_back({row, std::min(row + step, rows)});
  return strips;
}

}  // namespace lamella

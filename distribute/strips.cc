#include "distribute/strips.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "distribute/accumulate.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// More nodes at a time than those that are added together, while their samples take at most so many
// bytes.
constexpr double kNodesBytes = 64U << 20U;

// Of a beam along one axis, with its overlaps and the room that their lists have to grow.
constexpr double kBeamBytes = 128, kOverlapBytes = 96;
int Widest(const std::vector<SampleRange>& ranges) {
  int widest = 0;
  for (const SampleRange& range : ranges) widest = std::max(widest, range.size());
  return widest;
}

// Nodes that a beam reaches along an axis: it is as wide as its opening and its emitter.
double NodesOfBeam(const Display& display, const Layer& layer, const NodeAxis& axis) {
  // Of the steps between an element's eyes, those that one emitter's beam covers.
  const auto* bare = std::get_if<BarePanel>(&layer.optics);
  const double of_element = bare != nullptr ? bare->views : DirectionsPerAxis(layer);
  const double covered = of_element / std::max(1, SlotsPerAxis(layer)) + 1;
  return std::min(static_cast<double>(axis.count),
                  covered * AimStep(display, layer) / axis.step + 2);
}

// Of what light leaves by: an opening, a lens.
double ElementMm(const Display& display, const Layer& layer) {
  const auto* barrier = std::get_if<Barrier>(&layer.optics);
  return barrier != nullptr ? barrier->aperture_px * display.emitter_pitch_mm(layer)
                            : LatticePitchMm(display, layer);
}

// Samples that a beam takes on all planes of the blur together, along an axis.
double SamplesOfBlur(const Display& display, const Layer& layer, const NodeLattice& nodes,
                     const SampleAxis& samples) {
  const double element = ElementMm(display, layer);
  const double emitter = DirectionStepMm(display, layer);
  double taken = 0;
  for (const double z : nodes.planes_mm) {
    const double gaps = std::abs(z - layer.position_mm) / ReachMm(display, layer);
    const double width = element * (1 + gaps) + emitter * gaps;
    const double stretch =
        nodes.aim.points ? nodes.aim.distance_mm / (nodes.aim.distance_mm - z) : 1;
    taken += stretch * width / samples.size_mm + 2;
  }
  return taken;
}

double OverlapBytes(const Display& display, const Layer& layer, const NodeLattice& nodes,
                    const NodeAxis& axis, const SampleAxis& samples) {
  if (nodes.planes_mm.empty()) return kOverlapBytes * NodesOfBeam(display, layer, axis);
  // Lists of weights have room to grow.
  return static_cast<double>(nodes.planes_mm.size()) * kOverlapBytes +
         2 * sizeof(float) * SamplesOfBlur(display, layer, nodes, samples);
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
    const double along_x =
        kBeamBytes + OverlapBytes(display, layer, nodes, nodes.x, nodes.sample_x);
    const double along_y =
        kBeamBytes + OverlapBytes(display, layer, nodes, nodes.y, nodes.sample_y);
    const double families = HasRowFamilies(layer) ? rows : 2;
    bytes += k * EmitterColumns(display, layer) * families * along_x;
    bytes += k * (rows * along_y + display.emitter_rows() * kBeamBytes);
  }
  return bytes;
}

// An emitter's own beam: of each node that it meets, along both axes, an overlap and its weights.
double BytesOfOwnBeams(const Display& display, const NodeLattice& nodes, int rows) {
  const auto along = [&](const Layer& layer, const NodeAxis& axis, const SampleAxis& samples) {
    const double weights = ElementMm(display, layer) / samples.size_mm + 1;
    return NodesOfBeam(display, layer, axis) * (sizeof(Overlap) + sizeof(float) * weights);
  };
  double bytes = 0;
  for (const Layer& layer : display.layers) {
    const double k = SlotsPerAxis(layer);
    const double of_emitter =
        along(layer, nodes.x, nodes.sample_x) + along(layer, nodes.y, nodes.sample_y);
    const double of_row = sizeof(std::vector<Overlap>) * (nodes.x.count + nodes.y.count);
    bytes += k * k * rows * (EmitterColumns(display, layer) * of_emitter + of_row);
  }
  return bytes;
}

// Rows of samples that a beam takes.
double SampleRowsOfBeam(const Display& display, const NodeLattice& nodes) {
  int elements = 0;
  for (const Layer& layer : display.layers) elements = std::max(elements, DirectionsPerAxis(layer));
  return display.emitter_pitch_mm() / nodes.sample_y.size_mm * (elements + 2);
}

// Rows of samples of a node that a strip of `rows` rows takes. What their beams reach beyond the
// strip, by their width and by where layers and panels stand, is what all rows' beams reach beyond
// the panel.
int SampleRows(const Display& display, const NodeLattice& nodes, int rows) {
  const int whole = Widest(nodes.samples_y);
  const double per_row = display.emitter_pitch_mm() / nodes.sample_y.size_mm;
  if (!nodes.planes_mm.empty()) return whole;
  const double beyond =
      std::max(SampleRowsOfBeam(display, nodes), whole - per_row * display.emitter_rows());
  const double needed = std::ceil(per_row * rows) + std::ceil(beyond);
  return static_cast<int>(std::min(needed, static_cast<double>(std::max(whole, 1))));
}

double BytesOfSamples(const Display& display, const NodeLattice& nodes, int rows) {
  return static_cast<double>(Widest(nodes.samples_x)) * SampleRows(display, nodes, rows) *
         sizeof(RaySample);
}

}  // namespace

double BytesOfStrips(const Display& display, const NodeLattice& nodes, const RaySource& source,
                     bool own_beams, int rows, int nodes_at_a_time) {
  const int width = Widest(nodes.samples_x), height = SampleRows(display, nodes, rows);
  int columns = 0, columns_of_slots = 0;
  double groups = 1;  // of nodes, that filter to the same column
  for (const Layer& layer : display.layers) {
    columns = std::max(columns, EmitterColumns(display, layer));
    columns_of_slots =
        std::max(columns_of_slots, SlotsPerAxis(layer) * EmitterColumns(display, layer));
    groups = std::max(groups, NodesOfBeam(display, layer, nodes.x) / kNodesTogether + 1);
  }
  groups = std::min(groups, static_cast<double>(nodes_at_a_time) / kNodesTogether);
  const bool blurs = !nodes.planes_mm.empty();
  // A thread takes the rows of samples of one beam from each node, for two layers, and filters them
  // to columns of up to two families, for which it keeps weights; it gives away a block of emitters
  // in two forms.
  const double filtered = blurs ? height : std::ceil(SampleRowsOfBeam(display, nodes));
  const double of_thread =
      2 * (nodes_at_a_time * filtered * width + 2 * groups * (filtered + 2) * columns_of_slots) *
          sizeof(Light) +
      2.0 * kBlockRows * columns * (sizeof(Rgb) + sizeof(float));
  const double beams =
      own_beams ? BytesOfOwnBeams(display, nodes, rows) : BytesOfBeams(display, nodes, rows);
  // The blur holds apart what is unknown, and a node's samples of a plane.
  return (blurs ? 2 : 1) * BytesOfSums(display, rows) + beams +
         (blurs ? 3 : 1) * nodes_at_a_time * BytesOfSamples(display, nodes, rows) +
         source.QueryBytes(width, height) + NumThreads() * of_thread;
}

int NodesAtATime(const Display& display, const NodeLattice& nodes, const RaySource& source,
                 bool own_beams, int rows, double bytes) {
  if (own_beams || !nodes.planes_mm.empty()) return kNodesTogether;
  const double of_node = std::max(BytesOfSamples(display, nodes, rows), 1.0);
  int at_a_time = kNodesTogether;
  while (at_a_time < nodes.x.count) {
    const int more = at_a_time + kNodesTogether;
    if (more * of_node > kNodesBytes) break;
    if (BytesOfStrips(display, nodes, source, own_beams, rows, more) > bytes) break;
    at_a_time = more;
  }
  return at_a_time;
}

std::vector<Strip> StripsOf(const Display& display, const NodeLattice& nodes,
                            const RaySource& source, bool own_beams, double bytes) {
  const int rows = display.emitter_rows();
  int count = 1, step = rows;
  while (step > kBlockRows && BytesOfStrips(display, nodes, source, own_beams, step) > bytes) {
    ++count;
    step = ((rows + count - 1) / count + kBlockRows - 1) / kBlockRows * kBlockRows;
  }
  std::vector<Strip> strips;
  for (int row = 0; row < rows; row += step) strips.push_back({row, std::min(row + step, rows)});
  return strips;
}

}  // namespace lamella

#include "distribute/distribute.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "distribute/accumulate.h"
#include "distribute/assign.h"
#include "distribute/calibrated_beams.h"
#include "distribute/depth_blur.h"
#include "distribute/emitter_beams.h"
#include "distribute/nodes.h"
#include "distribute/seen_rays.h"
#include "distribute/strips.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Below this the colour of an emitter, light / coverage, would be rounding noise.
constexpr float kLeastCoverage = 1e-5F;
constexpr double kGib = 1073741824;

Kernel KernelOf(const std::string& name) {
  return name == "lens" ? Kernel::kLens : name == "ray" ? Kernel::kRay : Kernel::kBeam;
}

LayerWeights WeightsOf(const Display& display, const LayersOptions& options) {
  Display shown = display;
  shown.border_mm = options.border_mm.value_or(display.border_mm);
  shown.border_offset_mm = options.border_offset_mm.value_or(display.border_offset_mm);
  return WeightsOf(shown);
}

std::vector<CalibratedMap> MapsOf(const Display& display, const Calibration* calibration) {
  std::vector<CalibratedMap> maps;
  if (calibration == nullptr) return maps;
  for (std::size_t layer = 0; layer < display.layers.size(); ++layer) {
    maps.emplace_back(display, *calibration, static_cast<int>(layer));
  }
  return maps;
}

std::vector<LayerBeams> EnclosingBeams(const Display& display,
                                       const std::vector<CalibratedMap>& maps,
                                       const LayersOptions& options) {
  const Directions directions =
      options.directions == "ideal" ? Directions::kIdeal : Directions::kTrue;
  std::vector<LayerBeams> beams(display.layers.size());
  ParallelForEach(0, static_cast<std::int64_t>(beams.size()), [&](std::int64_t layer) {
    const std::size_t l = static_cast<std::size_t>(layer);
    const int index = static_cast<int>(layer);
    beams[l] = maps.empty() ? EnclosingBeamsOf(display, index, directions)
                            : EnclosingBeamsOf(maps[l], display, index);
  });
  return beams;
}

// Emitters with beams of their own lie between those that enclose them.
void WidenSamples(const Display& display, int samples_per_pixel, std::vector<SampleRange>& nodes) {
  int emitters = 2;
  for (const Layer& layer : display.layers) {
    emitters = std::max(emitters, 2 + static_cast<int>(PeriodPx(display, layer)));
  }
  for (SampleRange& range : nodes) {
    if (range.size() == 0) continue;
    range.first -= emitters * samples_per_pixel;
    range.end += emitters * samples_per_pixel;
  }
}

NodeLattice NodesOf(const Display& display, const std::vector<LayerBeams>& beams, bool own_beams,
                    const LayersOptions& options) {
  NodeLattice nodes = NodesFor(
      display, beams, options.nodes_per_step, options.samples_per_pixel, KernelOf(options.kernel),
      options.prefilter == "blur" ? DepthBlurPlanes(display, beams) : std::vector<double>());
  if (own_beams) WidenSamples(display, options.samples_per_pixel, nodes.samples_x);
  if (own_beams) WidenSamples(display, options.samples_per_pixel, nodes.samples_y);
  nodes.scatter = options.scatter;
  return nodes;
}

// places[column]: of the column in a row of sums.
using ColumnPlaces = std::vector<int>;

// Puts columns that one node adds to beside each other, by their first node: sums are too many for
// the cache, and on the panel a node's emitters lie a period apart. By slot; the overlaps then name
// places instead of columns.
std::vector<ColumnPlaces> SortColumnsByNode(int slots, int columns, std::vector<AxisOverlaps>& x) {
  std::vector<ColumnPlaces> places(Index(slots), ColumnPlaces(Index(columns), -1));
  std::vector<int> next(Index(slots), 0);
  for (std::size_t node = 0; node < x.at(0).nodes.size(); ++node) {
    for (AxisOverlaps& family : x) {
      for (Overlap& overlap : family.nodes[node]) {
        int& place = places[Index(overlap.slot)][Index(overlap.emitter)];
        if (place < 0) place = next[Index(overlap.slot)]++;
        overlap.emitter = place;
      }
    }
  }
  for (AxisOverlaps& family : x) {
    for (std::vector<Overlap>& node : family.nodes) {
      std::sort(node.begin(), node.end(), [](const Overlap& a, const Overlap& b) {
        return std::pair(a.slot, a.emitter) < std::pair(b.slot, b.emitter);
      });
    }
  }
  for (std::size_t slot = 0; slot < places.size(); ++slot) {
    for (int& place : places[slot]) {
      if (place < 0) place = next[slot]++;  // dark
    }
  }
  return places;
}

// Of the rows [first_row, end_row) of the sums. The weights of the gather are 1 in all, those of
// the blur `blurred` are what they are, with the ones of what is `unknown` (null: nothing).
EmitterImage Normalised(const Image<Light>& sums, bool blurred, const Image<Light>* unknown,
                        const ColumnPlaces& places, int first_row, int end_row) {
  EmitterImage image{Image<Rgb>(sums.width(), end_row - first_row),
                     Image<float>(sums.width(), end_row - first_row)};
  for (int y = 0; y < image.color.height(); ++y) {
    for (int x = 0; x < sums.width(); ++x) {
      const Light& sum = sums(places[Index(x)], first_row + y);
      if (sum.coverage < kLeastCoverage) continue;
      const float scale = 1 / sum.coverage;
      image.color(x, y) = {scale * sum.r, scale * sum.g, scale * sum.b};
      float all = blurred ? sum.coverage : 1;
      if (unknown != nullptr) all += (*unknown)(places[Index(x)], first_row + y).coverage;
      image.coverage(x, y) = std::min(sum.coverage / all, 1.0F);
    }
  }
  return image;
}

// Pixels from their three sub-pixels, of which each shows its own channel.
EmitterImage Joined(const EmitterImage& subpixels) {
  const int columns = subpixels.color.width() / 3, rows = subpixels.color.height();
  EmitterImage image{Image<Rgb>(columns, rows), Image<float>(columns, rows)};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const Rgb* color = subpixels.color.row(y) + 3 * x;
      const float* coverage = subpixels.coverage.row(y) + 3 * x;
      image.color(x, y) = {color[0].r, color[1].g, color[2].b};
      image.coverage(x, y) = (coverage[0] + coverage[1] + coverage[2]) / 3;
    }
  }
  return image;
}

class Distributor {
 public:
  Distributor(const RaySource& source, const Display& display, const LayersOptions& options,
              const Calibration* calibration)
      : source_(source),
        display_(calibration != nullptr ? AsCalibrated(display, *calibration) : display),
        maps_(MapsOf(display_, calibration)),
        kernel_(KernelOf(options.kernel)),
        weights_(WeightsOf(display_, options)),
        beams_(EnclosingBeams(display_, maps_, options)),
        nodes_(NodesOf(display_, beams_, !maps_.empty(), options)),
        strips_(StripsOf(display_, nodes_, source, !maps_.empty(), options.memory_gib * kGib)),
        samples_(Index(NodesAtATime(display_, nodes_, source, !maps_.empty(), strips_.at(0).rows(),
                                    options.memory_gib * kGib))),
        blur_(nodes_.planes_mm, display_.layers.size()),
        layers_(display_.layers.size()),
        sums_(display_.layers.size()) {
    if (!maps_.empty()) beams_.clear();  // they only told which rays to ask for
  }

  SeenShares Run(const PictureSize& picture, const TakeEmitterRows& take, Progress& progress) {
    progress.Start("layers",
                   static_cast<std::int64_t>(strips_.size()) * nodes_.x.count * nodes_.y.count,
                   "nodes");
    for (const Strip& strip : strips_) RunStrip(strip, picture, take, progress);
    return {all_.Share(), in_picture_.Share()};
  }

 private:
  // What a layer's sums are made of; of those without row families only the rows change.
  struct LayerStrip {
    LayerBeams beams;
    std::vector<ColumnPlaces> places;  // by slot along x
    // By slot and row, of emitters with beams of their own.
    std::vector<Ways> ways;
  };

  // Of a layer; by plane where pictures are blurred.
  LayerOverlaps& OverlapsAt(int layer, int plane) {
    return blur_.on() ? blur_.Overlaps(layer, plane) : sums_[Index(layer)].overlaps;
  }

  void BeginColumns(int index, LayerStrip& strip) {
    const Layer& of = display_.layers[Index(index)];
    for (int plane = 0; plane < nodes_.NumPlanes(); ++plane) {
      std::vector<AxisOverlaps>& x = OverlapsAt(index, plane).x;
      x.clear();
      for (const auto& family : strip.beams.columns) {
        x.push_back(OverlapsAlongX(nodes_, family, of.position_mm, kernel_, plane));
      }
      // The same on all planes: each beam has one node there.
      strip.places = SortColumnsByNode(SlotsPerAxis(of), EmitterColumns(display_, of), x);
    }
  }

  // One row of emitters with beams of their own.
  void BeginOwnRow(int index, const PictureSize& picture, OwnOverlaps& own,
                   std::vector<Way>& ways) const {
    const double z = display_.layers[Index(index)].position_mm;
    const RowOfBeams beams = BeamsOfRow(maps_[Index(index)], display_, index, own.slot, own.row);
    own.x = OverlapsOf(beams.x, z, nodes_.aim, z, nodes_.x, nodes_.sample_x, kernel_);
    // Rows are found by their columns.
    std::vector<EmitterBeam> y = beams.y;
    for (std::size_t i = 0; i < y.size(); ++i) y[i].emitter = beams.x[i].emitter;
    own.y = OverlapsOf(y, z, nodes_.aim, z, nodes_.y, nodes_.sample_y, kernel_);
    for (AxisOverlaps* axis : {&own.x, &own.y}) {  // they are kept, and many
      axis->weights.shrink_to_fit();
      for (std::vector<Overlap>& node : axis->nodes) node.shrink_to_fit();
    }
    ways.assign(Index(EmitterColumns(display_, display_.layers[Index(index)])), Way::kDark);
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double element_z = z + y[i].offset_mm;
      const bool within = PassesWithin(beams.x[i].beam, element_z, picture.width_mm) &&
                          PassesWithin(y[i].beam, element_z, picture.height_mm);
      ways[Index(y[i].emitter)] = within ? Way::kThroughPicture : Way::kBesidePicture;
    }
  }

  void BeginOwn(const Strip& rows, int index, const PictureSize& picture, LayerStrip& strip,
                LayerSums& sums) const {
    const Layer& layer = display_.layers[Index(index)];
    const int k = SlotsPerAxis(layer), slots = k * k;
    ColumnPlaces in_order(Index(EmitterColumns(display_, layer)));
    std::iota(in_order.begin(), in_order.end(), 0);
    strip.places.assign(Index(k), in_order);
    strip.ways.assign(Index(slots), Ways(Index(rows.rows())));
    sums.overlaps.own.resize(Index(slots * rows.rows()));
    ParallelForEach(0, static_cast<std::int64_t>(slots) * rows.rows(), [&](std::int64_t i) {
      OwnOverlaps& own = sums.overlaps.own[static_cast<std::size_t>(i)];
      own.slot = static_cast<int>(i) / rows.rows();
      const int row = static_cast<int>(i) % rows.rows();
      own.row = rows.first_row + row;
      BeginOwnRow(index, picture, own, strip.ways[Index(own.slot)][Index(row)]);
    });
    BeginSums(rows, layer, sums.sums);
  }

  void Begin(const Strip& rows, int index, const PictureSize& picture, LayerStrip& strip,
             LayerSums& sums) {
    if (!maps_.empty()) return BeginOwn(rows, index, picture, strip, sums);
    const Layer& layer = display_.layers[Index(index)];
    if (HasRowFamilies(layer)) {
      strip.beams = BeamsOf(display_, index, rows.first_row, rows.end_row);
      BeginColumns(index, strip);
    } else {
      if (strip.places.empty()) {
        strip.beams.columns = beams_[Index(index)].columns;
        BeginColumns(index, strip);
      }
      strip.beams.rows.clear();
      for (const EmitterBeam& row : beams_[Index(index)].rows) {
        if (row.emitter >= rows.first_row && row.emitter < rows.end_row)
          strip.beams.rows.push_back(row);
      }
    }
    for (int plane = 0; plane < nodes_.NumPlanes(); ++plane) {
      OverlapsAt(index, plane).y =
          OverlapsAlongY(nodes_, strip.beams.rows, layer.position_mm, kernel_, plane);
    }
    BeginSums(rows, layer, sums.sums);
  }

  // Of zeros, in the memory of the strip before.
  void BeginSums(const Strip& rows, const Layer& layer, EmitterSums& sums) const {
    const int k = SlotsPerAxis(layer), columns = EmitterColumns(display_, layer);
    sums.slots_per_axis = k;
    sums.first_row = rows.first_row;
    sums.slots.resize(Index(k * k));
    for (Image<Light>& slot : sums.slots) {
      if (slot.height() == rows.rows()) {
        std::fill_n(slot.data(), slot.size(), Light());
      } else {
        slot = {};  // before there is another
        slot = Image<Light>(columns, rows.rows());
      }
    }
  }

  void RunStrip(const Strip& strip, const PictureSize& picture, const TakeEmitterRows& take,
                Progress& progress) {
    ParallelForEach(0, static_cast<std::int64_t>(layers_.size()), [&](std::int64_t layer) {
      const std::size_t l = static_cast<std::size_t>(layer);
      Begin(strip, static_cast<int>(layer), picture, layers_[l], sums_[l]);
    });
    blur_.BeginStrip();
    std::vector<SampleRange> rows(Index(nodes_.y.count));
    for (int node_y = 0; node_y < nodes_.y.count; ++node_y) rows[Index(node_y)] = RowsFor(node_y);
    MakeRoom(rows);
    for (int node_y = 0; node_y < nodes_.y.count; ++node_y) {
      const SampleRange& y = rows[Index(node_y)];
      const int at_a_time = static_cast<int>(samples_.size());
      for (int node_x = 0; node_x < nodes_.x.count; node_x += at_a_time) {
        const int end_x = std::min(node_x + at_a_time, nodes_.x.count);
        AddNodes(node_x, end_x, node_y, y);
        progress.Advance(end_x - node_x);
      }
    }
    for (int layer = 0; layer < static_cast<int>(layers_.size()); ++layer) {
      Finish(layer, picture, take);
    }
  }

  // The rows of samples that the strip needs at a node.
  SampleRange RowsFor(int node_y) const {
    std::vector<const AxisOverlaps*> axes;
    blur_.AddAxesOfRows(axes);
    for (const LayerSums& layer : sums_) {
      if (maps_.empty() && !blur_.on()) axes.push_back(&layer.overlaps.y);
      for (const OwnOverlaps& own : layer.overlaps.own) axes.push_back(&own.y);
    }
    const SampleRange needed = SamplesOf(axes, node_y), &all = nodes_.samples_y[Index(node_y)];
    const SampleRange rows{std::max(needed.first, all.first), std::min(needed.end, all.end)};
    return rows.size() > 0 ? rows : SampleRange{};
  }

  // For any nodes.
  void MakeRoom(const std::vector<SampleRange>& rows) {
    int width = 0, height = 0;
    for (const SampleRange& x : nodes_.samples_x) width = std::max(width, x.size());
    for (const SampleRange& y : rows) height = std::max(height, y.size());
    for (Image<RaySample>& room : samples_) {
      if (room.width() >= width && room.height() >= height) continue;
      room = {};
      room = Image<RaySample>(width, height);
    }
  }

  // Asks the source once for all layers and slots.
  NodeSamples Ask(int node_x, int node_y, const SampleRange& y, Image<RaySample>& room) const {
    const RayBundle bundle = RaysOfNode(nodes_, node_x, node_y);
    const Rect rays{0, y.first - nodes_.samples_y[Index(node_y)].first, bundle.width, y.size()};
    const ImageSpan<RaySample> samples = room.span().Sub({0, 0, rays.width, rays.height});
    source_.Query(bundle, rays, samples);
    return {node_x, nodes_.samples_x[Index(node_x)].first, y.first, samples};
  }

  // Nodes [first_x, end_x) of a row of nodes.
  void AddNodes(int first_x, int end_x, int node_y, const SampleRange& y) {
    if (y.size() == 0) return;
    std::vector<NodeSamples> nodes;
    for (int node_x = first_x; node_x < end_x; ++node_x) {
      if (nodes_.samples_x[Index(node_x)].size() == 0) continue;
      nodes.push_back(Ask(node_x, node_y, y, samples_[Index(node_x - first_x)]));
    }
    if (blur_.on()) return blur_.Add(nodes, node_y, weights_, sums_);
    Accumulate(nodes, node_y, weights_, sums_);
  }

  void Finish(int layer, const PictureSize& picture, const TakeEmitterRows& take) {
    const LayerStrip& strip = layers_[Index(layer)];
    EmitterSums& sums = sums_[Index(layer)].sums;
    const bool subpixels =
        EmitterColumns(display_, display_.layers[Index(layer)]) != display_.emitter_columns();
    const double z = display_.layers[Index(layer)].position_mm;
    const int k = sums.slots_per_axis;
    std::vector<SeenRays> all(sums.slots.size()), in_picture(all.size());
    ParallelForEach(0, static_cast<std::int64_t>(all.size()), [&](std::int64_t s) {
      const std::size_t slot = static_cast<std::size_t>(s);
      const SeenCounter count_all(strip.beams, z, static_cast<int>(s), k, {});
      const SeenCounter count_picture(strip.beams, z, static_cast<int>(s), k, picture);
      const int rows = sums.slots[slot].height();
      for (int row = 0; row < rows; row += kBlockRows) {
        EmitterRows some{
            layer, static_cast<int>(s), sums.first_row + row,
            Normalised(sums.slots[slot], blur_.on(), blur_.Unknown(layer, slot),
                       strip.places[slot % Index(k)], row, std::min(row + kBlockRows, rows))};
        if (maps_.empty()) {
          count_all.Add(some.first_row, some.emitters.coverage, all[slot]);
          count_picture.Add(some.first_row, some.emitters.coverage, in_picture[slot]);
        } else {
          CountOwn(strip.ways[slot], row, some.emitters.coverage, all[slot], in_picture[slot]);
        }
        if (subpixels) some.emitters = Joined(some.emitters);
        take(std::move(some));
      }
      if (strips_.size() == 1) sums.slots[slot] = {};
    });
    for (const SeenRays& some : all) all_.Add(some);
    for (const SeenRays& some : in_picture) in_picture_.Add(some);
  }

  const RaySource& source_;
  const Display display_;
  const std::vector<CalibratedMap> maps_;  // of its layers; none: as designed
  const Kernel kernel_;
  const LayerWeights weights_;
  std::vector<LayerBeams> beams_;
  NodeLattice nodes_;
  const std::vector<Strip> strips_;
  std::vector<Image<RaySample>> samples_;  // room for each of the nodes that are added at a time
  DepthBlur blur_;
  std::vector<LayerStrip> layers_;
  std::vector<LayerSums> sums_;
  SeenRays all_, in_picture_;
};

}  // namespace

RayBundle MiddleRays(const Display& display, const LayersOptions& options) {
  const double size = display.emitter_pitch_mm() / options.samples_per_pixel;
  RayBundle rays;
  rays.centre = {0, 0, display.viewing_distance_mm, 1};
  rays.origin = {-display.width_mm() / 2, display.height_mm() / 2, 0};
  rays.dx = {size, 0, 0};
  rays.dy = {0, -size, 0};
  rays.width = display.emitter_columns() * options.samples_per_pixel;
  rays.height = display.emitter_rows() * options.samples_per_pixel;
  return rays;
}

double LeastBytes(const RaySource& source, const Display& display, const LayersOptions& options,
                  const Calibration* calibration) {
  const bool own_beams = calibration != nullptr;
  const Display as_it_is = own_beams ? AsCalibrated(display, *calibration) : display;
  const std::vector<CalibratedMap> maps = MapsOf(as_it_is, calibration);
  const std::vector<LayerBeams> beams = EnclosingBeams(as_it_is, maps, options);
  const NodeLattice nodes = NodesOf(as_it_is, beams, own_beams, options);
  const std::vector<Strip> strips = StripsOf(as_it_is, nodes, source, own_beams, 0);
  return BytesOfStrips(as_it_is, nodes, source, own_beams, strips[0].rows());
}

SeenShares Distribute(const RaySource& source, const Display& display, const LayersOptions& options,
                      const PictureSize& picture, const TakeEmitterRows& take, Progress& progress,
                      const Calibration* calibration) {
  Check(display, display.name);
  CheckOptions(options, display, calibration != nullptr);
  if (calibration != nullptr) CheckCalibrates(*calibration, display, "calibration");
  return Distributor(source, display, options, calibration).Run(picture, take, progress);
}

LayerImages Distribute(const RaySource& source, const Display& display,
                       const LayersOptions& options, Progress& progress,
                       const Calibration* calibration) {
  LayersOptions at_once = options;
  at_once.memory_gib = std::numeric_limits<double>::infinity();
  LayerImages images;
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  for (const Layer& layer : display.layers) {
    std::vector<EmitterImage>& slots = images.slots.emplace_back();
    for (int slot = 0; slot < SlotsPerAxis(layer) * SlotsPerAxis(layer); ++slot) {
      slots.push_back({Image<Rgb>(columns, rows), Image<float>(columns, rows)});
    }
  }
  const TakeEmitterRows take = [&](const EmitterRows& some) {
    EmitterImage& to = images.slots[Index(some.layer)][Index(some.slot)];
    const EmitterImage& from = some.emitters;
    std::copy_n(from.color.data(), from.color.size(), to.color.row(some.first_row));
    std::copy_n(from.coverage.data(), from.coverage.size(), to.coverage.row(some.first_row));
  };
  images.seen_share = Distribute(source, display, at_once, {}, take, progress, calibration).of_all;
  return images;
}

}  // namespace lamella

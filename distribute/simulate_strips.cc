#include "distribute/simulate_strips.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <variant>

#include "distribute/seen_elements.h"
#include "distribute/seen_layer.h"
#include "distribute/strips.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr double kPixelBytes = sizeof(Rgb) + sizeof(float);

// Some rows of a viewer's picture and what they need.
struct PictureBand {
  std::size_t viewer = 0;
  RowRange picture;
  double height_mm = 0;            // of their first line of sight on z = 0
  std::vector<RowRange> emitters;  // by layer
};

// Rows are read in blocks, as files have them.
RowRange InBlocks(const RowRange& rows, int all_rows) {
  if (rows.size() <= 0) return {};
  const int end = (rows.end + kBlockRows - 1) / kBlockRows * kBlockRows;
  return {rows.first / kBlockRows * kBlockRows, std::min(end, all_rows)};
}

std::vector<PictureBand> BandsOf(const Display& display, const Viewer& viewer, std::size_t index) {
  const Eye& eye = viewer.eye;
  std::vector<PictureBand> bands;
  for (int first = 0; first < eye.height; first += kPictureBandRows) {
    const double y = eye.top_mm - first * eye.pixel_mm, at = eye.position.y();
    const double to_z0 = eye.position.z() / (eye.position.z() - eye.plane_mm);
    bands.push_back({index,
                     {first, std::min(first + kPictureBandRows, eye.height)},
                     at + (y - at) * to_z0,
                     std::vector<RowRange>(display.layers.size())});
  }
  for (const Eye& sample :
       viewer.pupil ? PupilSamples(eye, *viewer.pupil) : std::vector<Eye>{eye}) {
    for (std::size_t l = 0; l < display.layers.size(); ++l) {
      const std::vector<RowRange> rows = SeenEmitterRows(display, static_cast<int>(l), sample);
      for (std::size_t b = 0; b < bands.size(); ++b) {
        bands[b].emitters[l] = bands[b].emitters[l].With(InBlocks(rows[b], display.emitter_rows()));
      }
    }
  }
  return bands;
}

// From the top to the bottom of z = 0.
std::vector<PictureBand> BandsOfAll(const Display& display, const std::vector<Viewer>& viewers) {
  std::vector<std::vector<PictureBand>> of_viewer(viewers.size());
  ParallelForEach(0, std::ssize(viewers), [&](std::int64_t i) {
    const auto v = static_cast<std::size_t>(i);
    of_viewer[v] = BandsOf(display, viewers[v], v);
  });
  std::vector<PictureBand> bands;
  for (std::vector<PictureBand>& more : of_viewer) {
    std::move(more.begin(), more.end(), std::back_inserter(bands));
  }
  std::stable_sort(bands.begin(), bands.end(), [](const PictureBand& a, const PictureBand& b) {
    return a.height_mm > b.height_mm;
  });
  return bands;
}

// Of a row of a layer's emitters: its pixels in all slots and their mean where modulators leak, and
// the elements of lenses, whose list has room to grow.
double BytesOfRow(const Display& display, const Layer& layer) {
  const double k = SlotsPerAxis(layer), columns = display.emitter_columns();
  const double images = (k * k + (Leaks(layer) ? 1 : 0)) * columns * kPixelBytes;
  const auto* lenses = std::get_if<LensletArray>(&layer.optics);
  if (lenses == nullptr) return images;
  return images + 2 * sizeof(SeenElement) * columns / lenses->pitch_px / lenses->row_pitch_px();
}

// The rows, and the copies that threads make of slots while the window moves.
double BytesOfWindow(const std::vector<RowRange>& rows, const Display& display) {
  double bytes = 0;
  int most = 0;
  for (std::size_t l = 0; l < rows.size(); ++l) {
    bytes += rows[l].size() * BytesOfRow(display, display.layers[l]);
    most = std::max(most, rows[l].size());
  }
  // What decoding a block takes, about: its pixels in four copies.
  constexpr int kBlock = 4 * kBlockRows;
  return bytes + NumThreads() * (most + kBlock) * display.emitter_columns() * kPixelBytes;
}

// The first rows that each band or one after it needs, which a window there must not leave behind.
std::vector<std::vector<int>> FirstRowsToCome(const std::vector<PictureBand>& bands,
                                              const Display& display) {
  std::vector<int> first(display.layers.size(), display.emitter_rows());
  std::vector<std::vector<int>> to_come(bands.size());
  for (std::size_t i = bands.size(); i-- > 0;) {
    for (std::size_t l = 0; l < first.size(); ++l) {
      const RowRange& rows = bands[i].emitters[l];
      if (rows.size() > 0) first[l] = std::min(first[l], rows.first);
    }
    to_come[i] = first;
  }
  return to_come;
}

void AddPart(const PictureBand& band, std::vector<EmitterStripPlan::Part>& parts) {
  for (EmitterStripPlan::Part& part : parts) {
    if (part.viewer != band.viewer) continue;
    part.picture = part.picture.With(band.picture);
    return;
  }
  parts.push_back({band.viewer, band.picture});
}

// Rows of emitters, which move downwards over the panels.
class EmitterWindow {
 public:
  EmitterWindow(const OpenEmitters& open, const Display& display)
      : display_(display), rows_(display.layers.size()) {
    for (std::size_t l = 0; l < rows_.size(); ++l) {
      const int k = SlotsPerAxis(display.layers[l]);
      std::vector<ReadEmitterRows>& slots = readers_.emplace_back();
      for (int slot = 0; slot < k * k; ++slot) slots.push_back(open(static_cast<int>(l), slot));
      images_.slots.emplace_back(slots.size());
    }
  }

  EmitterStrip MoveTo(const std::vector<RowRange>& rows) {
    std::vector<std::pair<std::size_t, std::size_t>> all;
    for (std::size_t l = 0; l < readers_.size(); ++l) {
      for (std::size_t s = 0; s < readers_[l].size(); ++s) all.emplace_back(l, s);
    }
    ParallelForEach(0, std::ssize(all), [&](std::int64_t i) {
      const auto [l, s] = all[static_cast<std::size_t>(i)];
      Move(readers_[l][s], rows_[l], rows[l], images_.slots[l][s]);
    });
    rows_ = rows;
    std::vector<int> first_row;
    for (const RowRange& of_layer : rows_) first_row.push_back(of_layer.first);
    return StripOf(images_, std::move(first_row), display_);
  }

 private:
  void Move(const ReadEmitterRows& read, const RowRange& from, const RowRange& to,
            EmitterImage& image) const {
    const int columns = display_.emitter_columns();
    EmitterImage moved{Image<Rgb>(columns, to.size()), Image<float>(columns, to.size())};
    for (int y = to.first; y < std::min(from.end, to.end); ++y) {
      std::copy_n(image.color.row(y - from.first), columns, moved.color.row(y - to.first));
      std::copy_n(image.coverage.row(y - from.first), columns, moved.coverage.row(y - to.first));
    }
    ReadRows(read, {std::max(from.end, to.first), to.end}, to.first, moved);
    image = std::move(moved);
  }

  const Display& display_;
  std::vector<std::vector<ReadEmitterRows>> readers_;  // [layer][slot]
  LayerImages images_;
  std::vector<RowRange> rows_;  // by layer, that are held
};

}  // namespace

std::vector<EmitterStripPlan> PlanStrips(const Display& display, const std::vector<Viewer>& viewers,
                                         double bytes) {
  for (const Viewer& viewer : viewers) CheckEye(display, viewer.eye);
  const std::vector<PictureBand> bands = BandsOfAll(display, viewers);
  const std::vector<std::vector<int>> to_come = FirstRowsToCome(bands, display);
  std::vector<EmitterStripPlan> plan;
  std::vector<int> end(display.layers.size());  // never falls, for rows to be read once
  for (std::size_t i = 0; i < bands.size(); ++i) {
    for (std::size_t l = 0; l < end.size(); ++l) {
      end[l] = std::max(end[l], bands[i].emitters[l].end);
    }
    std::vector<RowRange> higher, anew;
    for (std::size_t l = 0; l < end.size(); ++l) {
      if (!plan.empty()) higher.push_back({plan.back().emitters[l].first, end[l]});
      anew.push_back({std::min(to_come[i][l], end[l]), end[l]});
    }
    if (plan.empty() || BytesOfWindow(higher, display) > bytes) {
      plan.push_back({std::move(anew), {}});
    } else {
      plan.back().emitters = std::move(higher);
    }
    AddPart(bands[i], plan.back().parts);
  }
  return plan;
}

double BytesOf(const std::vector<EmitterStripPlan>& plan, const Display& display) {
  double most = 0;
  for (const EmitterStripPlan& strip : plan) {
    most = std::max(most, BytesOfWindow(strip.emitters, display));
  }
  return most;
}

void SimulateStrips(const std::vector<EmitterStripPlan>& plan, const OpenEmitters& open,
                    const Display& display, const std::vector<Viewer>& viewers,
                    const TakePictureRows& take) {
  EmitterWindow window(open, display);
  for (const EmitterStripPlan& planned : plan) {
    const EmitterStrip strip = window.MoveTo(planned.emitters);
    for (const EmitterStripPlan::Part& part : planned.parts) {
      const Viewer& viewer = viewers[part.viewer];
      take(part.viewer, part.picture.first,
           SimulateRows(strip, display, viewer.eye, viewer.pupil, part.picture));
    }
  }
}

}  // namespace lamella

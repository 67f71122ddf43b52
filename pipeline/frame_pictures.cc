#include "pipeline/frame_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "depth/resize_area.h"
#include "distribute/panel_pixels-inl.h"
#include "lightfield/color.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/emitter_rows.h"
#include "pipeline/json_file.h"
#include "pipeline/report/picture.h"
#include "pipeline/slot_frames.h"
#include "pipeline/varifocal_frames.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// Together at most some 6 MB of the page's 20, were all of it noise; of a scene a tenth of that.
constexpr int kMostSlotsOnPage = 96;              // of all layers
constexpr double kPixelsOnPage = 2.5e6;           // of all pictures of whole panels
constexpr int kMostWholeWidth = 480;              // px
constexpr int kPartWidth = 96, kPartHeight = 64;  // px

// Of a layer's pictures.
struct Sizes {
  int panel_width = 0, panel_height = 0, whole_width = 0, whole_height = 0;
  std::size_t most_slots = 1;
  Rect part = {};  // of the panel
};

// All but the part.
Sizes SizesFor(int width, int height, std::size_t layers, std::size_t slots) {
  Sizes sizes{width, height};
  sizes.most_slots = std::clamp<std::size_t>(kMostSlotsOnPage / layers, 1, slots);
  const double pictures = static_cast<double>(layers * (sizes.most_slots + 1));
  const double scale = std::min({1.0, static_cast<double>(kMostWholeWidth) / width,
                                 std::sqrt(kPixelsOnPage / pictures / width / height)});
  const auto scaled = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(scale * length)));
  };
  sizes.whole_width = scaled(width);
  sizes.whole_height = scaled(height);
  return sizes;
}

// ---- Which part ----

double VarianceOf(ImageSpan<const Rgb> light) {
  double sum = 0, squares = 0;
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      const double value = static_cast<double>(Luminance(light(x, y)));
      sum += value;
      squares += value * value;
    }
  }
  const double n = static_cast<double>(light.width) * light.height;
  return squares / n - sum / n * (sum / n);
}

// Copies a part of a picture whose rows come from the top on, and may come again.
void TakeRow(const Rect& part, int y, const Rgb* row, Image<Rgb>& taken) {
  if (y < part.y || y >= part.y + part.height) return;
  std::copy_n(row + part.x, part.width, taken.row(y - part.y));
}

// The part of the emitters with the most contrast, since much of a layer is black; the middle one
// where there is none.
Rect VariedPart(const Display& display, const RowOf& light, int width, int height) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  const Rect middle{(columns - width) / 2, (rows - height) / 2, width, height};
  Image<Rgb> in_middle(width, height), strip(columns, height);
  std::vector<std::pair<double, Rect>> parts;
  for (int y = 0; y < rows; ++y) {
    const Rgb* row = light(y, nullptr);
    TakeRow(middle, y, row, in_middle);
    std::copy_n(row, columns, strip.row(y % height));
    if (y % height != height - 1) continue;
    for (int x = 0; x + width <= columns; x += width) {
      parts.emplace_back(VarianceOf(strip.span().Sub({x, 0, width, height})),
                         Rect{x, y + 1 - height, width, height});
    }
  }
  std::pair<double, Rect> most{VarianceOf(in_middle.span()), middle};
  for (const auto& part : parts) {
    if (part.first > most.first) most = part;
  }
  return most.second;
}

// `binning` pixels an emitter and axis; `mirrored`: of a panel that is flipped in x.
Sizes WithPart(Sizes sizes, const Display& display, const RowOf& light, int binning,
               bool mirrored) {
  const Rect part =
      VariedPart(display, light, std::clamp(kPartWidth / binning, 1, display.emitter_columns()),
                 std::clamp(kPartHeight / binning, 1, display.emitter_rows()));
  sizes.part = {part.x * binning, part.y * binning, part.width * binning, part.height * binning};
  if (mirrored) sizes.part.x = sizes.panel_width - sizes.part.x - sizes.part.width;
  return sizes;
}

// ---- Pictures ----

// Linear light.
struct PanelView {
  Image<Rgb> whole, part;
};

// Of rows that are asked for from the top on.
PanelView ViewOf(const Sizes& sizes, const RowOf& row_of) {
  PanelView view{{}, Image<Rgb>(sizes.part.width, sizes.part.height)};
  view.whole = ResizeAreaDownwards(
      sizes.panel_width, sizes.panel_height,
      [&](int y, Rgb* buffer) {
        const Rgb* row = row_of(y, buffer);
        TakeRow(sizes.part, y, row, view.part);
        return row;
      },
      sizes.whole_width, sizes.whole_height);
  return view;
}

using LightTable = std::array<float, 256>;  // of every code

LightTable LightOfEveryCode() {
  Image<Rgb8> ramp(256, 1);
  for (int code = 0; code < 256; ++code) ramp(code, 0).g = static_cast<std::uint8_t>(code);
  const Image<Rgb> light = DecodeSrgb8(ramp.span());
  LightTable table{};
  for (int code = 0; code < 256; ++code)
    table.at(static_cast<std::size_t>(code)) = light(code, 0).g;
  return table;
}

RowOf LightOfCodes(const Image<Rgb8>& codes) {
  return [&codes, table = LightOfEveryCode()](int y, Rgb* buffer) {
    const Rgb8* row = codes.row(y);
    for (int x = 0; x < codes.width(); ++x) {
      buffer[x] = {table[row[x].r], table[row[x].g], table[row[x].b]};
    }
    return buffer;
  };
}

// What goes straight on through a modulator, whose codes are 255 where it is open and else 0.
RowOf LightThrough(const Image<Rgb8>& emitter, const Image<Rgb8>& modulator) {
  return [&, light = LightOfCodes(emitter)](int y, Rgb* buffer) {
    light(y, buffer);
    const Rgb8* opened = modulator.row(y);
    for (int x = 0; x < modulator.width(); ++x) {
      if (opened[x].g == 0) buffer[x] = {};
    }
    return buffer;
  };
}

// `weight` times the sum of all.
PanelView SumOf(const std::vector<PanelView>& views, const Sizes& sizes, float weight) {
  PanelView sum{Image<Rgb>(sizes.whole_width, sizes.whole_height),
                Image<Rgb>(sizes.part.width, sizes.part.height)};
  for (const PanelView& view : views) {
    for (const auto image : {&PanelView::whole, &PanelView::part}) {
      for (std::size_t i = 0; i < (view.*image).size(); ++i) {
        (sum.*image).data()[i] += weight * (view.*image).data()[i];
      }
    }
  }
  return sum;
}

std::vector<PagePicture> PicturesOf(const PanelView& view, const Rect& part,
                                    const std::string& caption) {
  return {
      {DataUri(EncodeSrgb8(view.whole.span()).span(), "jpeg", 80), caption, false},
      {DataUri(EncodeSrgb8(view.part.span()).span(), "png"),
       fmt::format("The marked part, pixel by pixel, from column {} and row {} on", part.x, part.y),
       true}};
}

// ---- Slots ----

std::string NameOfSlot(int slot, int slots_per_axis) {
  if (slots_per_axis == 1) return "the only one";
  return fmt::format("{} (x {}, y {})", slot, slot % slots_per_axis, slot / slots_per_axis);
}

std::string NameOfAll(std::size_t slots) { return fmt::format("all {} together", slots); }

// Straight ahead a barrier lets a pixel's light pass in (k a / P)^2 slots on average: once where
// the openings tile the panel, which then shows the sum as it is.
float WeightOfSlot(const Barrier& barrier) {
  const double times = static_cast<double>(barrier.slots) * barrier.aperture_px / barrier.period_px;
  return static_cast<float>(1 / std::max(1.0, times * times));
}

std::vector<PageSlot> SlotsOfBarrier(const fs::path& folder, const Display& display, int layer,
                                     const Barrier& barrier, const Sizes& sizes) {
  const int k = barrier.slots;
  std::vector<PageSlot> slots(static_cast<std::size_t>(k * k));
  std::vector<PanelView> ahead(slots.size());
  ParallelForEach(0, k * k, [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const int slot = static_cast<int>(i);
    const std::string emits = FrameFile(layer, slot, "emitter");
    const std::string opens = FrameFile(layer, slot, "modulator");
    const Image<Rgb8> emitter = ReadFrame(folder / emits, display);
    const Image<Rgb8> modulator = ReadFrame(folder / opens, display);
    ahead[at] = ViewOf(sizes, LightThrough(emitter, modulator));
    if (at >= sizes.most_slots) return;
    slots[at] = {NameOfSlot(slot, k),
                 PicturesOf(ViewOf(sizes, LightOfCodes(emitter)), sizes.part, "Emitter: " + emits)};
    slots[at].pictures.push_back({DataUri(modulator.span().Sub(sizes.part), "png"),
                                  "Modulator there, white is open: " + opens, true});
  });
  slots.resize(std::min(slots.size(), sizes.most_slots));
  if (k == 1) return slots;
  slots.insert(slots.begin(),
               {NameOfAll(ahead.size()),
                PicturesOf(SumOf(ahead, sizes, WeightOfSlot(barrier)), sizes.part,
                           "Sum of the slots, emitter times modulator: what the layer sends "
                           "straight ahead over a period")});
  return slots;
}

std::vector<PageSlot> SlotsOfLenses(const fs::path& folder, const Display& display, int layer,
                                    const Sizes& sizes) {
  const std::string file = FrameFile(layer, 0, "emitter");
  const Image<Rgb8> emitter = ReadFrame(folder / file, display);
  return {{NameOfSlot(0, 1),
           PicturesOf(ViewOf(sizes, LightOfCodes(emitter)), sizes.part, "Emitter: " + file)}};
}

PageSlot SlotOfStroke(const Image<std::uint32_t>& bits, int plane, const StrokeFrames& strokes,
                      std::size_t stroke, const Sizes& sizes) {
  const auto shift = static_cast<unsigned>(plane);
  const PanelView view = ViewOf(sizes, [&](int y, Rgb* buffer) {
    for (int x = 0; x < bits.width(); ++x) {
      buffer[x] = (bits(x, y) >> shift & 1U) != 0 ? Rgb{1, 1, 1} : Rgb{};
    }
    return buffer;
  });
  return {fmt::format("{}", stroke),
          PicturesOf(view, sizes.part,
                     fmt::format("Plane {}, one bit of {}", plane, strokes.files[stroke]))};
}

// The rows of a panel from those of its emitters.
RowOf PanelRowsOf(const RowOf& emitters, const Display& display, const Layer& layer) {
  return [&, emitters](int y, Rgb* buffer) {
    const Rgb* row = emitters(y / display.binning_px, nullptr);
    for (int x = 0; x < display.width_px; ++x) {
      const int column = layer.mirror_x ? display.width_px - 1 - x : x;
      buffer[x] = row[column / display.binning_px];
    }
    return buffer;
  };
}

// What the strokes of a plane decode to is their mean.
PageSlot SlotOfAllStrokes(const RowOf& mean, const Display& display, const Layer& layer,
                          const StrokeFrames& strokes, const Sizes& sizes) {
  return {NameOfAll(strokes.files.size()),
          PicturesOf(ViewOf(sizes, PanelRowsOf(mean, display, layer)), sizes.part,
                     "Mean of the strokes: the plane's grey")};
}

// ---- The figure ----

std::size_t MostSlots(const Display& display) {
  int most = 1;
  for (const Layer& layer : display.layers) most = std::max(most, SlotsPerAxis(layer));
  return static_cast<std::size_t>(most) * static_cast<std::size_t>(most);
}

PageSteps StepsWith(const Sizes& sizes, const Display& display, const std::string& slot_name,
                    std::size_t slots) {
  PageSteps steps;
  steps.slot_name = slot_name;
  steps.width = sizes.panel_width;
  steps.height = sizes.panel_height;
  steps.layers.resize(display.layers.size());
  steps.note = fmt::format(
      "The large picture is the whole panel of {} x {} px, made smaller by averages of linear "
      "light: single pixels are gone, and a lattice of lenses or openings may beat with the "
      "picture's own. The small ones show some of its pixels one by one, enlarged, where the "
      "layer has most contrast.",
      sizes.panel_width, sizes.panel_height);
  if (sizes.most_slots < slots) {
    steps.note += fmt::format(" Of {} {}s a layer the first {} are here.", slots, slot_name,
                              sizes.most_slots);
  }
  if (std::holds_alternative<Lenticular>(display.layers[0].optics)) {
    steps.note += " Each channel of a pixel is a sub-pixel with a ray of its own.";
  }
  return steps;
}

std::string NoteOnFiles(const Display& display) {
  const bool mirrored = std::any_of(display.layers.begin(), display.layers.end(),
                                    [](const Layer& layer) { return layer.mirror_x; });
  return mirrored ? "From the files of frames/, in which a panel that is seen in a mirror is "
                    "flipped. "
                  : "From the files of frames/. ";
}

Sizes SizesOfLayer(const Sizes& sizes, const Display& display, std::size_t layer,
                   const OpenEmitters& shown) {
  return WithPart(sizes, display, LightRows(shown, display, static_cast<int>(layer), 0),
                  display.binning_px, display.layers[layer].mirror_x);
}

PageSteps StepsOfStrokes(const fs::path& folder, const Display& display,
                         const StrokeFrames& strokes, const OpenEmitters& shown) {
  const Sizes sizes =
      SizesFor(display.width_px, display.height_px, display.layers.size(), strokes.files.size());
  PageSteps steps = StepsWith(sizes, display, "stroke", strokes.files.size());
  steps.note = NoteOnFiles(display) + steps.note;
  std::vector<Sizes> of_plane(display.layers.size());
  ParallelForEach(0, std::ssize(of_plane), [&](std::int64_t i) {
    const auto plane = static_cast<std::size_t>(i);
    of_plane[plane] = SizesOfLayer(sizes, display, plane, shown);
    PageStepLayer& layer = steps.layers[plane];
    layer.part = of_plane[plane].part;
    layer.slots.resize(sizes.most_slots + 1);
    layer.slots[0] = SlotOfAllStrokes(LightRows(shown, display, static_cast<int>(i), 0), display,
                                      display.layers[plane], strokes, of_plane[plane]);
  });
  ParallelForEach(0, static_cast<std::int64_t>(sizes.most_slots), [&](std::int64_t i) {
    const auto stroke = static_cast<std::size_t>(i);
    const Image<std::uint32_t> bits =
        UnpackedFrame(ReadFrame(folder / strokes.files[stroke], display).span(), strokes.planes,
                      static_cast<int>(i), strokes.packing);
    for (int plane = 0; plane < strokes.planes; ++plane) {
      const auto at = static_cast<std::size_t>(plane);
      steps.layers[at].slots[stroke + 1] = SlotOfStroke(bits, plane, strokes, stroke, of_plane[at]);
    }
  });
  return steps;
}

}  // namespace

PageSteps StepsOfFrames(const fs::path& folder, const Display& display, const OpenEmitters& shown) {
  if (const std::optional<StrokeFrames> strokes = LoadStrokeFrames(folder, display)) {
    return StepsOfStrokes(folder, display, *strokes, shown);
  }
  const std::size_t slots = MostSlots(display);
  const Sizes sizes = SizesFor(display.width_px, display.height_px, display.layers.size(), slots);
  PageSteps steps = StepsWith(sizes, display, "time slot", slots);
  steps.note = NoteOnFiles(display) + steps.note;
  const std::string curve = JsonObject(folder / "frames.json").Object("response").Text("curve");
  if (curve != "srgb") {
    steps.note +=
        fmt::format(" Codes are drawn as sRGB; the panels' response is another ({}).", curve);
  }
  ParallelForEach(0, std::ssize(steps.layers), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const int layer = static_cast<int>(i);
    const Sizes of_layer = SizesOfLayer(sizes, display, at, shown);
    const auto* barrier = std::get_if<Barrier>(&display.layers[at].optics);
    steps.layers[at] = {of_layer.part,
                        barrier != nullptr
                            ? SlotsOfBarrier(folder, display, layer, *barrier, of_layer)
                            : SlotsOfLenses(folder, display, layer, of_layer)};
  });
  return steps;
}

PageSteps StepsOfLayers(const Display& display, const OpenEmitters& emitters) {
  const std::size_t slots = MostSlots(display);
  const Sizes sizes =
      SizesFor(display.emitter_columns(), display.emitter_rows(), display.layers.size(), slots);
  PageSteps steps = StepsWith(sizes, display, "time slot", slots);
  steps.note =
      "The emitters' light before it becomes frames, from the front: the eyes are simulated from "
      "it, not from the panels' files. " +
      steps.note;
  ParallelForEach(0, std::ssize(steps.layers), [&](std::int64_t i) {
    const auto layer = static_cast<std::size_t>(i);
    const int index = static_cast<int>(i), k = SlotsPerAxis(display.layers[layer]);
    const Sizes of_layer =
        WithPart(sizes, display, LightRows(emitters, display, index, 0), 1, false);
    steps.layers[layer].part = of_layer.part;
    for (int slot = 0; slot < std::min(k * k, static_cast<int>(sizes.most_slots)); ++slot) {
      const PanelView view = ViewOf(of_layer, LightRows(emitters, display, index, slot));
      steps.layers[layer].slots.push_back(
          {NameOfSlot(slot, k), PicturesOf(view, of_layer.part, "Light of the emitters")});
    }
  });
  return steps;
}

}  // namespace lamella

#include "pipeline/frame_pictures.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "depth/resize_area.h"
#include "distribute/panel_pixels-inl.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/json_file.h"
#include "pipeline/report/picture.h"
#include "pipeline/slot_frames.h"
#include "pipeline/varifocal_frames.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// Together some 6 MB of the page's 20, were all of it noise; a tenth of that for a scene.
constexpr int kMostSlotsOnPage = 96;              // of all layers
constexpr double kPixelsOnPage = 2.5e6;           // of all pictures of whole panels
constexpr int kMostWholeWidth = 480;              // px
constexpr int kPartWidth = 96, kPartHeight = 64;  // px

// Of what size the pictures are.
struct Sizes {
  int panel_width, panel_height, whole_width, whole_height;
  Rect part;                   // of the panel
  std::size_t most_slots = 1;  // of a layer
};

Sizes SizesFor(int width, int height, std::size_t layers, std::size_t slots) {
  Sizes sizes{width, height, 0, 0, {}};
  sizes.most_slots = std::clamp<std::size_t>(kMostSlotsOnPage / layers, 1, slots);
  const double pictures = static_cast<double>(layers * (sizes.most_slots + 1));
  const double scale = std::min({1.0, static_cast<double>(kMostWholeWidth) / width,
                                 std::sqrt(kPixelsOnPage / pictures / width / height)});
  const auto scaled = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(scale * length)));
  };
  sizes.whole_width = scaled(width);
  sizes.whole_height = scaled(height);
  const int part_width = std::min(kPartWidth, width), part_height = std::min(kPartHeight, height);
  sizes.part = {(width - part_width) / 2, (height - part_height) / 2, part_width, part_height};
  return sizes;
}

// Linear light.
struct PanelView {
  Image<Rgb> whole, part;
};

PanelView ViewOf(const Sizes& sizes, const RowOf& row_of) {
  PanelView view{ResizeArea(sizes.panel_width, sizes.panel_height, row_of, sizes.whole_width,
                            sizes.whole_height),
                 Image<Rgb>(sizes.part.width, sizes.part.height)};
  std::vector<Rgb> buffer(static_cast<std::size_t>(sizes.panel_width));
  for (int y = 0; y < sizes.part.height; ++y) {
    std::copy_n(row_of(sizes.part.y + y, buffer.data()) + sizes.part.x, sizes.part.width,
                view.part.row(y));
  }
  return view;
}

RowOf LightOf(const Image<Rgb8>& codes) {
  return [&codes](int y, Rgb* buffer) {
    const Image<Rgb> light = DecodeSrgb8(codes.span().Sub({0, y, codes.width(), 1}));
    return std::copy_n(light.data(), light.width(), buffer) - light.width();
  };
}

// What goes straight on through a modulator, whose codes are 255 where it is open and else 0.
RowOf LightThrough(const Image<Rgb8>& emitter, const Image<Rgb8>& modulator) {
  return [&, light = LightOf(emitter)](int y, Rgb* buffer) {
    light(y, buffer);
    for (int x = 0; x < modulator.width(); ++x) {
      if (modulator(x, y).g == 0) buffer[x] = {};
    }
    return buffer;
  };
}

// weight * the sum of all.
PanelView SumOf(const std::vector<PanelView>& views, float weight) {
  PanelView sum{Image<Rgb>(views[0].whole.width(), views[0].whole.height()),
                Image<Rgb>(views[0].part.width(), views[0].part.height())};
  for (const PanelView& view : views) {
    for (const auto image : {&PanelView::whole, &PanelView::part}) {
      for (std::size_t i = 0; i < (sum.*image).size(); ++i) {
        (sum.*image).data()[i] += weight * (view.*image).data()[i];
      }
    }
  }
  return sum;
}

PagePicture WholePicture(const PanelView& view, const std::string& caption) {
  return {DataUri(EncodeSrgb8(view.whole.span()).span(), "jpeg", 80), caption, false};
}

PagePicture PartPicture(const PanelView& view, const std::string& caption) {
  return {DataUri(EncodeSrgb8(view.part.span()).span(), "png"), caption, true};
}

std::vector<PagePicture> BothPictures(const PanelView& view, const std::string& caption) {
  return {WholePicture(view, caption), PartPicture(view, "The marked part, pixel by pixel")};
}

// A sum comes first, that of `all`; then the slots, of which there may be more than on the page.
std::vector<PageSlot> WithSum(std::vector<PageSlot> slots, const std::string& name,
                              const PanelView& all, const std::string& caption) {
  slots.insert(slots.begin(), {name, BothPictures(all, caption)});
  return slots;
}

std::string NameOfSlot(int slot, int slots_per_axis) {
  return fmt::format("{} (x {}, y {})", slot, slot % slots_per_axis, slot / slots_per_axis);
}

// A panel of barriers sends every pixel's light straight ahead in (k a / P)^2 slots, once where
// the openings tile it: the sum is then as bright as the layer is over a period relative to white.
float SumWeight(const Barrier& barrier) {
  const double times = static_cast<double>(barrier.slots) * barrier.aperture_px / barrier.period_px;
  return static_cast<float>(1 / std::max(1.0, times * times));
}

std::vector<PageSlot> SlotsOfLayer(const fs::path& folder, const Display& display, int layer,
                                   const Sizes& sizes) {
  const auto* barrier =
      std::get_if<Barrier>(&display.layers[static_cast<std::size_t>(layer)].optics);
  const int k = barrier != nullptr ? barrier->slots : 1;
  std::vector<PageSlot> slots(static_cast<std::size_t>(k * k));
  std::vector<PanelView> ahead(barrier != nullptr ? slots.size() : 0);
  ParallelForEach(0, k * k, [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const int slot = static_cast<int>(i);
    const std::string file = FrameFile(layer, slot, "emitter");
    const Image<Rgb8> emitter = ReadFrame(folder / file, display);
    if (at < sizes.most_slots) {
      slots[at] = {NameOfSlot(slot, k),
                   BothPictures(ViewOf(sizes, LightOf(emitter)), "Emitter: " + file)};
    }
    if (barrier == nullptr) return;
    const std::string opened = FrameFile(layer, slot, "modulator");
    const Image<Rgb8> modulator = ReadFrame(folder / opened, display);
    ahead[at] = ViewOf(sizes, LightThrough(emitter, modulator));
    if (at >= sizes.most_slots) return;
    slots[at].pictures.push_back({DataUri(modulator.span().Sub(sizes.part), "png"),
                                  "Modulator there, white is open: " + opened, true});
  });
  slots.resize(std::min(slots.size(), sizes.most_slots));
  if (k == 1) return slots;
  return WithSum(std::move(slots), fmt::format("all {} together", k * k),
                 SumOf(ahead, SumWeight(*barrier)),
                 "Sum of the slots, emitter times modulator: what the layer sends straight ahead "
                 "over a period");
}

// By plane: the mean of all strokes, which is `shown`, and the first strokes.
std::vector<std::vector<PageSlot>> SlotsOfStrokes(const fs::path& folder,
                                                  const StrokeFrames& strokes,
                                                  const Display& display, const LayerImages& shown,
                                                  const Sizes& sizes) {
  std::vector<std::vector<PageSlot>> planes(display.layers.size(),
                                            std::vector<PageSlot>(sizes.most_slots));
  ParallelForEach(0, std::ssize(planes[0]), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const std::string& file = strokes.files[at];
    const Image<std::uint32_t> bits =
        UnpackedFrame(ReadFrame(folder / file, display).span(), strokes.planes, static_cast<int>(i),
                      strokes.packing);
    for (std::size_t plane = 0; plane < planes.size(); ++plane) {
      const PanelView view = ViewOf(sizes, [&](int y, Rgb* buffer) {
        for (int x = 0; x < bits.width(); ++x) {
          buffer[x] = (bits(x, y) >> plane & 1U) != 0 ? Rgb{1, 1, 1} : Rgb{};
        }
        return buffer;
      });
      planes[plane][at] = {fmt::format("{}", at),
                           BothPictures(view, fmt::format("One bit of {}", file))};
    }
  });
  ParallelForEach(0, std::ssize(planes), [&](std::int64_t plane) {
    const auto at = static_cast<std::size_t>(plane);
    const Image<Rgb>& color = shown.slots[at][0].color;
    const Image<Rgb> mean = PanelFromEmitters<Rgb>(display, display.layers[at], color.height(),
                                                   [&](int x, int y) { return color(x, y); });
    planes[at] =
        WithSum(std::move(planes[at]), fmt::format("all {} together", strokes.files.size()),
                ViewOf(sizes, [&](int y, Rgb*) { return mean.row(y); }),
                "Mean of the strokes: the plane's grey");
  });
  return planes;
}

std::string NoteOn(const Sizes& sizes, const Display& display, std::size_t slots,
                   const std::string& slot_name) {
  std::string note = fmt::format(
      "The large picture is the whole panel of {} x {} px, made smaller by averages of linear "
      "light, in which single pixels are gone; the small ones show {} x {} of its pixels, each "
      "enlarged, from column {} and row {} on.",
      sizes.panel_width, sizes.panel_height, sizes.part.width, sizes.part.height, sizes.part.x,
      sizes.part.y);
  if (sizes.most_slots < slots) {
    note += fmt::format(" Of {} {}s a layer the first {} are here.", slots, slot_name,
                        sizes.most_slots);
  }
  const std::vector<Layer>& layers = display.layers;
  if (std::holds_alternative<Lenticular>(layers[0].optics)) {
    note += " Each channel of a pixel is a sub-pixel with a ray of its own.";
  }
  return note;
}

std::string NoteOnFiles(const Display& display) {
  const bool mirrored = std::any_of(display.layers.begin(), display.layers.end(),
                                    [](const Layer& layer) { return layer.mirror_x; });
  return fmt::format("The files of frames/ as they are{}. ",
                     mirrored ? ": that of a panel seen in a mirror is flipped" : "");
}

std::size_t MostSlots(const Display& display) {
  int most = 1;
  for (const Layer& layer : display.layers) most = std::max(most, SlotsPerAxis(layer));
  return static_cast<std::size_t>(most) * static_cast<std::size_t>(most);
}

PageSteps StepsWith(const Sizes& sizes, const std::string& slot_name, std::string note) {
  PageSteps steps;
  steps.note = std::move(note);
  steps.slot_name = slot_name;
  steps.width = sizes.panel_width;
  steps.height = sizes.panel_height;
  steps.part = sizes.part;
  return steps;
}

}  // namespace

PageSteps StepsOfFrames(const fs::path& folder, const Display& display, const LayerImages& shown) {
  const std::optional<StrokeFrames> strokes = LoadStrokeFrames(folder, display);
  const std::size_t slots = strokes ? strokes->files.size() : MostSlots(display);
  const std::string slot_name = strokes ? "stroke" : "time slot";
  const Sizes sizes = SizesFor(display.width_px, display.height_px, display.layers.size(), slots);
  std::string note = NoteOnFiles(display) + NoteOn(sizes, display, slots, slot_name);
  if (strokes) {
    PageSteps steps = StepsWith(sizes, slot_name, note);
    steps.layers = SlotsOfStrokes(folder, *strokes, display, shown, sizes);
    return steps;
  }
  const std::string curve = JsonObject(folder / "frames.json").Object("response").Text("curve");
  if (curve != "srgb") {
    note += fmt::format(" Codes are drawn as sRGB; the panels' response is another ({}).", curve);
  }
  PageSteps steps = StepsWith(sizes, slot_name, note);
  steps.layers.resize(display.layers.size());
  ParallelForEach(0, std::ssize(steps.layers), [&](std::int64_t layer) {
    steps.layers[static_cast<std::size_t>(layer)] =
        SlotsOfLayer(folder, display, static_cast<int>(layer), sizes);
  });
  return steps;
}

PageSteps StepsOfLayers(const Display& display, const LayerImages& layers) {
  const std::size_t slots = MostSlots(display);
  const Sizes sizes =
      SizesFor(display.emitter_columns(), display.emitter_rows(), display.layers.size(), slots);
  PageSteps steps = StepsWith(
      sizes, "time slot",
      "The emitters' light before it becomes frames, from the front: the eyes above are simulated "
      "from it, not from the panels' files. " +
          NoteOn(sizes, display, slots, "time slot"));
  steps.layers.resize(display.layers.size());
  ParallelForEach(0, std::ssize(steps.layers), [&](std::int64_t i) {
    const auto layer = static_cast<std::size_t>(i);
    const std::vector<EmitterImage>& emitters = layers.slots[layer];
    for (std::size_t slot = 0; slot < std::min(emitters.size(), sizes.most_slots); ++slot) {
      const PanelView view =
          ViewOf(sizes, [&](int y, Rgb*) { return emitters[slot].color.row(y); });
      steps.layers[layer].push_back(
          {NameOfSlot(static_cast<int>(slot), SlotsPerAxis(display.layers[layer])),
           BothPictures(view, "Light of the emitters")});
    }
  });
  return steps;
}

}  // namespace lamella

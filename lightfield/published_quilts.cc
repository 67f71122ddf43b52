#include "lightfield/published_quilts.h"

#include <array>

namespace lamella {
namespace {

struct Device {
  std::string_view mark;  // of its serials, after "LKG-"
  PublishedQuilt quilt;
};

constexpr PublishedQuilt kPortrait{8, 6, 3360, 3360}, kLandscape16{5, 9, 4096, 4096};

constexpr std::array<Device, 12> kDevices{{{"2K", {5, 9, 4096, 4096}},
                                           {"4K", {5, 9, 4096, 4096}},
                                           {"8K", {5, 9, 8192, 8192}},
                                           {"P", kPortrait},
                                           {"A", kLandscape16},
                                           {"B", {5, 9, 8192, 8192}},
                                           {"D", {8, 9, 8192, 8192}},
                                           {"E", {11, 6, 4092, 4092}},
                                           {"H", {11, 6, 5995, 6000}},
                                           {"J", {7, 7, 5999, 5999}},
                                           {"K", {11, 6, 8184, 8184}},
                                           {"L", {7, 7, 8190, 8190}}}};

}  // namespace

PublishedQuilt PublishedQuiltFor(std::string_view serial, bool upright) {
  constexpr std::string_view kMaker = "LKG-";
  if (serial.starts_with(kMaker)) {
    for (const Device& device : kDevices) {
      if (serial.substr(kMaker.size()).starts_with(device.mark)) return device.quilt;
    }
  }
  return upright ? kPortrait : kLandscape16;
}

LookingGlass NominalPortrait() {
  LookingGlass panel;
  panel.pitch_per_in = 52;
  panel.slope = -7;
  panel.center = 0.5;
  panel.dpi = 324;
  panel.width_px = 1536;
  panel.height_px = 2048;
  return panel;
}

}  // namespace lamella

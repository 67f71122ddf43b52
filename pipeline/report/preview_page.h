// preview/index.html: one self-contained file in which dragging moves the eye. The page's template,
// style and script stand beside this file and are part of the program.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lightfield/image.h"

namespace lamella {

// Pictures are data URIs (pipeline/report/picture.h).
struct PageEye {
  std::string simulated, target;
  std::optional<double> psnr_db, ssim;  // of the pixels that both know; nothing: there are none
  double known = 0;  // share of the display's light that comes from known emitters
  double seen = 0;   // share of the target that the capture saw
};

// The eye in the middle, focused on a plane.
struct PageFocus {
  double plane_mm = 0;
  std::string simulated, target;
  std::optional<double> psnr_db, ssim;  // as a PageEye's
};

struct PageDepthView {
  std::string name, photo, depth;
  double known = 0;  // share of its pixels
  bool reference = false;
};

struct PageLayer {
  std::string caption, mean;
};

// Of a layer's panel: all of it made smaller, or a part pixel by pixel.
struct PagePicture {
  std::string picture, caption;
  bool is_part = false;
};

// What a layer shows in a time slot, or over all of them.
struct PageSlot {
  std::string name;
  std::vector<PagePicture> pictures;
};

struct PageStepLayer {
  Rect part = {};  // of its panel, px
  std::vector<PageSlot> slots = {};
};

// The figure that steps through the layers and each one's slots.
struct PageSteps {
  std::string note, slot_name;
  int width = 0, height = 0;  // of a panel, px
  std::vector<PageStepLayer> layers;
};

struct PageTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

struct PageStage {
  std::string stage;
  double seconds = 0, peak_memory_mib = 0;
};

struct PreviewPage {
  std::string title, subtitle, foot;
  std::vector<double> x_mm, y_mm;  // eye positions; x rising, y falling (the highest eye first)
  double distance_mm = 0, clean_box_mm = 0;
  std::string beyond_box = "light of neighbouring windows";  // what eyes beyond it see
  int width = 0, height = 0;                                 // of the eyes' pictures
  std::vector<PageEye> eyes;                                 // row by row
  std::vector<PageFocus> focus;  // from the back to the front; empty: none
  double pupil_mm = 0;
  std::vector<PageDepthView> depth_views;
  std::vector<std::pair<double, std::string>> depth_ticks;  // share of the scale, text
  std::string depth_note;
  std::vector<PageLayer> layers;
  PageSteps steps;                  // through as many layers
  std::string cutoff, cutoff_text;  // a figure, and what it says in words; empty: none
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<PageStage> stages;
  std::vector<std::string> warnings;
  std::string metrics_note;
  std::vector<PageTable> tables;
};

std::string ToHtml(const PreviewPage& page);

}  // namespace lamella

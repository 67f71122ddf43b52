// The preview's pictures and how far the display is from the capture at each eye.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "distribute/angular_aliasing.h"
#include "distribute/band_limit.h"
#include "distribute/halo.h"
#include "distribute/simulate_eye.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"
#include "lightfield/view.h"
#include "pipeline/preview_eyes.h"

namespace lamella {

// 8-bit sRGB codes, as they are written and compared, and what share of a pixel is known or was
// seen.
struct PreviewPicture {
  Image<Rgb8> codes;
  Image<float> share;
};

struct EyeTarget {
  PreviewPicture picture;
  Image<Rgb8> band_limited;  // the same as the display's beams carry it; empty: no limit was given
  Image<Rim> rims = {};      // empty: nothing is occluded, or no shadows were given
  // Where it was asked for, all but what is seen: of the band-limited target, if there is one.
  std::optional<SeenAgainstTarget> light = {};
};

// What is made beside a target's picture.
struct TargetParts {
  const BandLimit* limit = nullptr;     // null: no band-limited target
  const ShadowBlur* shadows = nullptr;  // may be null; pinhole eyes alone have rims
  bool keeps_light = false;             // likewise
};

// The scene along the eye's rays: the mean over each pixel, as the simulated eye's is, by 2 x 2
// rays; through a pupil one or four for each of its points. An eye without a pupil is a pinhole.
// A pixel is as far away as the nearest thing in it is.
EyeTarget RenderTarget(const RaySource& placed, const Eye& eye, const std::optional<Pupil>& pupil,
                       double mm_per_view_px, const TargetParts& parts);
PreviewPicture PictureOf(const EyePicture& seen);
// Some rows of what an eye sees, from this one on, to its picture.
void KeepRows(const EyePicture& rows, int first_row, PreviewPicture& picture);
// The same to the kept light of its target.
void AddSeen(const EyePicture& rows, int first_row, SeenAgainstTarget& light);
// Every pixel becomes the grey of its luminance.
void LoseColor(Image<Rgb8>& codes);
// A captured view on the raster of its eye.
PreviewPicture CapturedPicture(ImageSpan<const Rgb> photograph, const CapturedEye& captured);

struct PreviewMetrics {
  std::optional<double> psnr_db;  // sRGB; +inf for equal pictures, nothing where no pixel counts
  std::optional<double> psnr_seen_db;  // over pixels with both shares at least 1/2
  std::optional<double> ssim, ssim_seen;
};
PreviewMetrics Compare(const PreviewPicture& a, const PreviewPicture& b, int border_px);

// What an eye sees, and the target itself, against the band-limited target, which must have been
// asked for; SSIM of the first only.
struct BandLimitMetrics {
  PreviewMetrics simulated, target;
};
BandLimitMetrics CompareToBandLimited(const PreviewPicture& simulated, const EyeTarget& target,
                                      int border_px);

// Of what an eye sees against its band-limited target, which must have been asked for, over the
// pixels that both know. Nothing where nothing is occluded.
std::optional<HaloErrors> MeasureHalo(const PreviewPicture& simulated, const EyeTarget& target,
                                      int border_px);

double MeanShare(const PreviewPicture& picture);

}  // namespace lamella

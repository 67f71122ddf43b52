#include "pipeline/preview_measure.h"

#include <algorithm>
#include <cmath>

#include "depth/resize_area.h"
#include "distribute/metrics.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"

namespace lamella {

PreviewPicture RenderTarget(const RaySource& placed, const Eye& eye, double mm_per_view_px) {
  const int split = std::clamp(static_cast<int>(std::lround(eye.pixel_mm / mm_per_view_px)), 1, 8);
  const RayBundle bundle = BundleOfEye(eye, split);
  Image<RaySample> samples(bundle.width, bundle.height);
  placed.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
  Image<Rgb> color(eye.width, eye.height);
  PreviewPicture picture;
  picture.share = Image<float>(eye.width, eye.height);
  const float weight = 1.0F / static_cast<float>(split * split);
  ParallelFor(0, eye.height, 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int sample_y = y * split; sample_y < (y + 1) * split; ++sample_y) {
        const RaySample* row = samples.row(sample_y);
        for (int x = 0; x < bundle.width; ++x) {
          color(x / split, y) += weight * row[x].color;
          picture.share(x / split, y) += weight * row[x].coverage;
        }
      }
    }
  });
  picture.codes = EncodeSrgb8(color.span());
  return picture;
}

PreviewPicture RenderSimulated(const LayerImages& layers, const Display& display, const Eye& eye) {
  EyePicture seen = SimulateEye(layers, display, eye);
  return {EncodeSrgb8(seen.color.span()), std::move(seen.coverage)};
}

PreviewPicture CapturedPicture(const View& view, const CapturedEye& captured) {
  const Image<Rgb> whole = ReadImage(view.image);
  const Eye& eye = captured.eye;
  const Image<Rgb> part = ResizeArea(whole.span().Sub(captured.pixels), eye.width, eye.height);
  return {EncodeSrgb8(part.span()), Image<float>(eye.width, eye.height, 1.0F)};
}

PreviewMetrics Compare(const PreviewPicture& a, const PreviewPicture& b, int border_px) {
  Image<float> both(a.share.width(), a.share.height());
  for (std::size_t i = 0; i < both.size(); ++i) {
    both.data()[i] = std::min(a.share.data()[i], b.share.data()[i]);
  }
  const MetricRegion all{border_px, {}}, seen{border_px, both.span()};
  return {Psnr(a.codes.span(), b.codes.span(), all), Psnr(a.codes.span(), b.codes.span(), seen),
          Ssim(a.codes.span(), b.codes.span(), all), Ssim(a.codes.span(), b.codes.span(), seen)};
}

double MeanShare(const PreviewPicture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.share.size(); ++i) {
    sum += static_cast<double>(picture.share.data()[i]);
  }
  return picture.share.empty() ? 0 : sum / static_cast<double>(picture.share.size());
}

}  // namespace lamella

#include "pipeline/preview_result.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Of the figures that there are and that are finite; nothing without any.
class MeanOfFigures {
 public:
  void Add(const std::optional<double>& value) {
    if (!value || !std::isfinite(*value)) return;
    sum_ += *value;
    ++count_;
  }
  std::optional<double> Value() const {
    return count_ > 0 ? std::optional(sum_ / count_) : std::nullopt;
  }

 private:
  double sum_ = 0;
  int count_ = 0;
};

}  // namespace

GridMeans MeansOf(const PreviewResult& result) {
  GridMeans means;
  MeanOfFigures psnr, ssim, to_limited, to_limited_ssim, limited;
  HaloErrors halo;
  const double n = static_cast<double>(result.grid.size());
  for (const EyeResult& eye : result.grid) {
    const std::optional<double>& decibels = eye.metrics.psnr_seen_db;
    psnr.Add(decibels);
    ssim.Add(eye.metrics.ssim_seen);
    if (decibels && std::isfinite(*decibels)) {
      means.worst_psnr_seen_db = std::min(means.worst_psnr_seen_db.value_or(*decibels), *decibels);
    }
    to_limited.Add(eye.band_limit.simulated.psnr_seen_db);
    to_limited_ssim.Add(eye.band_limit.simulated.ssim_seen);
    limited.Add(eye.band_limit.target.psnr_seen_db);
    if (eye.halo) halo += *eye.halo;
    means.known += MeanShare(eye.simulated) / n;
    means.seen += MeanShare(eye.target.picture) / n;
  }
  means.halo = FiguresOf(halo);
  means.psnr_seen_db = psnr.Value();
  means.ssim_seen = ssim.Value();
  means.to_band_limited_db = to_limited.Value();
  means.to_band_limited_ssim = to_limited_ssim.Value();
  means.band_limited_to_target_db = limited.Value();
  return means;
}

}  // namespace lamella

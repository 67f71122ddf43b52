#include "pipeline/poses/pair_selection.h"

#include <algorithm>
#include <numeric>

#include "lightfield/parallel.h"
#include "pipeline/poses/match.h"

namespace lamella {
namespace {

constexpr std::size_t kAllPairsUpTo = 50;
constexpr std::size_t kLargest = 256;
constexpr std::size_t kEnoughMatches = 8;
constexpr int kNeighbours = 5;

Descriptors Largest(const ImageFeatures& image) {
  std::vector<std::size_t> order(static_cast<std::size_t>(image.descriptors.count));
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return image.sizes[a] > image.sizes[b]; });
  order.resize(std::min(order.size(), kLargest));
  Descriptors largest;
  for (const std::size_t feature : order) {
    const auto row = image.descriptors.rows.begin() +
                     static_cast<std::ptrdiff_t>(feature) * Descriptors::kLength;
    largest.rows.insert(largest.rows.end(), row, row + Descriptors::kLength);
  }
  largest.count = static_cast<int>(order.size());
  return largest;
}

std::vector<std::pair<int, int>> AllPairs(int images) {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < images; ++i) {
    for (int j = i + 1; j < images; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

std::vector<std::pair<int, int>> SelectPairs(const std::vector<ImageFeatures>& images,
                                             Progress& progress) {
  std::vector<std::pair<int, int>> all = AllPairs(static_cast<int>(images.size()));
  if (images.size() <= kAllPairsUpTo) return all;
  std::vector<PackedDescriptors> largest;
  for (const ImageFeatures& image : images) largest.emplace_back(Largest(image));
  progress.Start("select pairs", static_cast<std::int64_t>(all.size()), "pairs");
  std::vector<char> chosen(all.size(), 0);
  ParallelFor(0, static_cast<std::int64_t>(all.size()), 64,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t p = first; p < last; ++p) {
                  const auto [i, j] = all[static_cast<std::size_t>(p)];
                  chosen[static_cast<std::size_t>(p)] =
                      j - i <= kNeighbours || MatchFeatures(largest[static_cast<std::size_t>(i)],
                                                            largest[static_cast<std::size_t>(j)])
                                                      .size() >= kEnoughMatches;
                }
                progress.Advance(last - first);
              });
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t p = 0; p < all.size(); ++p) {
    if (chosen[p] != 0) pairs.push_back(all[p]);
  }
  return pairs;
}

}  // namespace lamella

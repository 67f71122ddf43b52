// COLMAP 3.8 as a program, on the CPU and without a display. Every step but the extraction runs on
// one thread: with more, COLMAP's results differ from run to run.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lightfield/progress.h"

namespace lamella {

// Where the program is; nothing where it is not installed. The first line of its help, e.g.
// "COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo".
std::optional<std::string> FindColmap();
std::optional<std::string> ColmapVersion();
// MachineError with the command that installs it.
std::string RequireColmap();

struct ExtractionOptions {
  int image_size_px = 1000;  // longer side
  int features = 2000;       // per image
  int first_octave = 0;      // -1 doubles the image
};

// How easily a reconstruction starts and grows: the next is tried where one finds too little.
enum class MapperEffort {
  kUsual,    // COLMAP's own thresholds
  kRelaxed,  // starts from little parallax (near-collinear rigs, far scenes)
  kLast      // and from few matches
};

// One reconstruction in a folder of its own: FOLDER/images with safe names, FOLDER/database.db.
class Colmap {
 public:
  Colmap(std::filesystem::path folder, Progress& progress);

  std::filesystem::path Images() const { return folder_ / "images"; }
  std::filesystem::path Database() const { return folder_ / "database.db"; }

  // Images are numbered in the order of their names, which all must be in the folder.
  void ExtractFeatures(const std::vector<std::string>& names, const ExtractionOptions& options);
  // Writes the matches of COLMAP's raw lists into the database and verifies them geometrically.
  // COLMAP does this on one thread: the lists are done side by side. What comes out depends on how
  // the pairs are listed (its random numbers start anew with a list), not on the threads.
  void ImportMatches(const std::vector<std::filesystem::path>& lists, int num_pairs);
  // The folders of the models that were found; none where there was no pair to start from.
  std::vector<std::filesystem::path> Map(int num_images, MapperEffort effort);
  // With usual effort and the principal point free. May run beside Map, on another thread, and so
  // tells no progress; it ends early and without models where it is `wanted` no more.
  std::vector<std::filesystem::path> MapWithFreePrincipalPoint(const std::atomic<bool>& wanted);
  // Triangulates with the cameras of the model in `input` held; the folder of the new model,
  // or nothing where no point fits them.
  std::optional<std::filesystem::path> Triangulate(const std::filesystem::path& input,
                                                   int num_images);

 private:
  struct Outcome {
    bool succeeded = false;
    std::string reason;  // its last line that tells an error
  };
  Outcome Run(const std::string& verb, const std::vector<std::string>& arguments,
              const std::function<void(std::string_view)>& on_line);
  void ImportMatchesInto(const std::filesystem::path& database, const std::filesystem::path& list);
  // MachineError where it did not succeed.
  void Require(const std::string& verb, const Outcome& outcome) const;
  std::vector<std::filesystem::path> MapInto(const std::filesystem::path& output,
                                             const std::filesystem::path& database,
                                             std::map<std::string, std::string> options,
                                             const std::function<void(std::string_view)>& on_line);
  void CopyDatabase(const std::filesystem::path& to) const;
  std::filesystem::path FreshFolder(const std::string& name);

  std::string program_;
  std::filesystem::path folder_;
  Progress& progress_;
  std::atomic<int> attempts_ = 0;
};

}  // namespace lamella

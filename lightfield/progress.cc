#include "lightfield/progress.h"

namespace lamella {
namespace {

class Silent final : public Progress {
 public:
  void Start(std::string_view, std::int64_t, std::string_view) override {}
  void Advance(std::int64_t) override {}
  void Note(std::string_view) override {}
  void Warn(std::string_view) override {}
};

}  // namespace

Progress& SilentProgress() {
  static Silent silent;
  return silent;
}

}  // namespace lamella

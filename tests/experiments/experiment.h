// The claims of Ranieri et al. 2012 as measurements of the display that this program makes: one
// function a claim (ranieri2012.md section 8), which returns what it measured beside what is
// expected. Nothing is adjusted: a claim that comes out otherwise says so, with its reason.
#pragma once

#include <string>
#include <vector>

namespace lamella::experiments {

enum class Relation {
  kNear,      // |measured - expected| <= tolerance * |expected|
  kAtLeast,   // measured >= expected
  kAtMost,    // measured <= expected
  kReported,  // no claim about it
};

struct Row {
  std::string what;  // with its unit
  double measured = 0;
  Relation relation = Relation::kReported;
  double expected = 0, tolerance = 0;

  bool Holds() const;
};

Row Near(std::string what, double measured, double expected, double tolerance);
Row AtLeast(std::string what, double measured, double expected);
Row AtMost(std::string what, double measured, double expected);
Row Reported(std::string what, double measured);

enum class Stroke {
  kMeasured,    // points; a line through them where no closed form of the same name goes beside
  kSecond,      // measured, dashed
  kClosedForm,  // what is expected, a thin line
};

struct Curve {
  std::string name;
  std::vector<double> x, y;
  Stroke stroke = Stroke::kMeasured;
  std::string color_of = {};  // takes the colour of the curve of this name
};

struct Figure {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  bool log_x = false;
};

// More numbers than belong into rows.
struct Table {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  // NaN: not measured
  std::vector<std::string> names = {};    // of the rows, in a column of their own; or none
};

struct Experiment {
  std::string id;     // of ranieri2012.md section 8; "mtf" of displays.md section 1.3
  std::string claim;  // as it is worded there
  std::string set_up;
  std::vector<Row> rows;
  std::vector<Figure> figures;
  std::vector<Table> tables;
  std::string reason;  // why rows do not hold, or what the claim leaves out; may be empty
};

// kQuick measures fewer points of the same set-up, by the same tolerances: a test's share.
enum class Effort { kQuick, kFull };

Experiment MtfRows(Effort effort);           // displays.md section 1.3
Experiment DepthOfField(Effort effort);      // 1
Experiment HalfTheRays(Effort effort);       // 2
Experiment RayCounts(Effort effort);         // 3
Experiment OutsideTheRange(Effort effort);   // 4
Experiment EqualBandwidth(Effort effort);    // 5
Experiment Aliasing(Effort effort);          // 6
Experiment FuzzyBorders(Effort effort);      // 7
Experiment Shadows(Effort effort);           // 8
Experiment HaloWidth(Effort effort);         // 9
Experiment HaloStrength(Effort effort);      // 10
Experiment ShearedRays(Effort effort);       // 11
Experiment Accommodation(Effort effort);     // 12
Experiment SeenBrightness(Effort effort);    // 14
Experiment EnergyPartition(Effort effort);   // 15
Experiment SlotsAndDetail(Effort effort);    // 16
Experiment ViewRepeats(Effort effort);       // 17
Experiment SpeedForAccuracy(Effort effort);  // no claim of the paper

struct NamedExperiment {
  const char* id;
  Experiment (*run)(Effort);
};
const std::vector<NamedExperiment>& AllExperiments();

}  // namespace lamella::experiments

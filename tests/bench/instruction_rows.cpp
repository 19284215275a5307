#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include "core/formats/model_reader.hpp"
#include "core/layers/layers.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/gpio/step_planner.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/measured_call.hpp"
#include "tests/bench/process.hpp"

namespace contourd::bench {
namespace {

constexpr int kPlanes = 20;

// The work of a child process: number of calls, and of parts (segments, facets, bytes) in all.
struct Work {
  int calls = 0;
  double parts = 0;
};

template <typename Function>
Work at_planes(const ContourEngine& engine, Function&& at_height) {
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), kPlanes);
  Section section;
  Work work;
  for (const Millimeters z : heights) {
    at_height(z);  // warm-up
    slice_at(engine.model(), z, section);
    work.parts += static_cast<double>(section.segments.size());
  }
  for (const Millimeters z : heights) {
    contourd_measured_call([&] { at_height(z); });
    ++work.calls;
  }
  return work;
}

Work load(const std::filesystem::path& model) {
  double facets = 0;
  contourd_measured_call([&] {
    const HeightIndex index(read_model_file(model).facets);
    facets = static_cast<double>(index.facets().size());
  });
  return {1, facets};
}

Work read(const std::filesystem::path& model) {
  contourd_measured_call([&] { (void)read_model_file(model); });
  return {1, static_cast<double>(std::filesystem::file_size(model))};
}

// A move of 40 mm at 10 mm/s on a screw with 800 microsteps a mm.
constexpr std::int64_t kSteps = 32'000;
MotionLimits step_limits(bool s_curve) {
  MotionLimits limits{8'000, 20'000};
  if (s_curve) limits.jerk = 100'000;
  return limits;
}

Work plan_steps(bool s_curve) {
  StepPlanner planner(kSteps, step_limits(s_curve));
  Duration sum{};
  contourd_measured_call([&] {
    for (; !planner.finished(); planner.advance())
      sum += planner.next();
  });
  if (sum <= Duration{}) throw std::runtime_error("steps without a time");
  return {1, static_cast<double>(kSteps)};
}

class SunkLine final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool) noexcept override { return true; }
};
TimePoint time_of_steps{};  // StepEngine takes a plain function

// Does the stepping thread's work, except for its waits and system calls.
Work make_steps(bool s_curve) {
  SunkLine step, direction;
  StepEngine engine(step, direction, {}, []() noexcept { return time_of_steps; });
  engine.start({kSteps, step_limits(s_curve)});
  contourd_measured_call([&] {
    (void)engine.begin();
    while (engine.running()) {
      time_of_steps = engine.due();
      engine.act();
    }
  });
  return {1, static_cast<double>(engine.position())};
}

// Returns the number after a word, such as callgrind's "Collected : 123", in the output of the child and
// valgrind.
double number_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  if (at == std::string::npos) throw std::runtime_error("no \"" + word + "\" in: " + text);
  return std::stod(text.substr(at + word.size()));
}

struct Thing {
  std::string id, what, part;
  bool per_call;  // true: figure per call; false: per part
  std::string thing;
};

Row row_of(const Thing& thing, const std::filesystem::path& model) {
  const ProcessResult child = run_process({"valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                                           "--toggle-collect=contourd_measured_call", this_program().string(),
                                           "--measured", thing.thing, "--model", model.string()});
  const double instructions = number_after(child.output, "Collected : ");
  const double calls = number_after(child.output, "calls=");
  const double parts = number_after(child.output, "parts=");
  Row row{thing.id, thing.what, "instr."};
  row.figure = instructions / (thing.per_call ? calls : parts);
  row.note = fmt::format("{:.0f} a {}, {:.0f} {}s each", instructions / parts, thing.part, parts / calls,
                         thing.part);
  return row;
}

}  // namespace

void do_measured(const std::string& thing, const std::filesystem::path& model) {
  Work work;
  if (thing == "load") {
    work = load(model);
  } else if (thing == "read") {
    work = read(model);
  } else if (thing.starts_with("plan-")) {
    work = plan_steps(thing == "plan-s-curve");
  } else if (thing.starts_with("step-")) {
    work = make_steps(thing == "step-s-curve");
  } else {
    ContourEngine engine = fitted_engine(model, Pixels{1920}, Pixels{1080});
    work = at_planes(engine, [&](Millimeters z) {
      if (thing == "mask") {
        (void)engine.mask_at_z(z);
      } else {
        (void)engine.contours_at(to_nanometers(z - Millimeters{engine.model().bounds().min_z}).value());
      }
    });
  }
  fmt::print("calls={} parts={}\n", work.calls, work.parts);
  std::fflush(stdout);
}

std::vector<Row> instruction_rows(const Bench& bench) {
  const std::filesystem::path gyroid = bench.models.gyroid();
  const auto plate = bench.models.shared(kPlate), liver = bench.models.shared(kLiver);
  const Thing plate_mask{"instructions-mask-plate", "plate, instructions a mask 1920x1080", "segment", true,
                         "mask"};
  const Thing contours{"instructions-contours-liver", "liver, instructions a layer's linked contours",
                       "segment", true, "contours"};
  return {
      plate ? row_of(plate_mask, *plate) : skipped_rows({plate_mask.id}, kPlate).front(),
      row_of({"instructions-mask-gyroid", "gyroid, instructions a mask 1920x1080", "segment", true, "mask"},
             gyroid),
      liver ? row_of(contours, *liver) : skipped_rows({contours.id}, kLiver).front(),
      row_of({"instructions-load", "gyroid, instructions a facet read and indexed", "facet", false, "load"},
             gyroid),
      row_of({"instructions-ascii", "ASCII, instructions a byte read", "byte", false, "read"},
             bench.models.ascii_gyroid()),
      row_of({"instructions-plan", "trapezoid, instructions a step planned", "step", false, "plan-trapezoid"},
             {}),
      row_of({"instructions-plan-s-curve", "S-curve, the same", "step", false, "plan-s-curve"}, {}),
      row_of({"instructions-step", "trapezoid, instructions a step of the thread", "step", false,
              "step-trapezoid"},
             {}),
      row_of({"instructions-step-s-curve", "S-curve, the same", "step", false, "step-s-curve"}, {})};
}

}  // namespace contourd::bench

#include "daemon/progress/interrupted_print.hpp"

#include <map>
#include <memory>
#include <vector>

#include "daemon/print/layered_print.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

constexpr int kLayers = 4;

// A layer as it was lit.
struct LitLayer {
  Duration exposure{};
  Nanometers mask_height{};
  Mask mask;
  bool operator==(const LitLayer&) const = default;
};

// A print on a printer of its own, which records its progress and its lit layers.
class RecordedPrint final : public PrintObserver {
 public:
  explicit RecordedPrint(bool homes_upwards) : machine(clock, config(homes_upwards)) {}

  // Prints to the end, or until `cut` progresses are recorded.
  void run(std::optional<ResumePoint> resume, std::size_t cut = SIZE_MAX) {
    PrintPlan plan = testing::box_plan(kLayers);
    plan.resume = resume;
    process->start(std::move(plan));
    while (progresses.size() < cut && clock.run_next())
      least = std::min(least, machine.z_axis().height().value_or(least));
  }

  void light_due() override {}
  void state_changed(const PrintState&) override {
    if (process->layered_state() == LayeredState::Igniting) masks[process->layer()] = *process->shown().mask;
    if (process->layered_state() == LayeredState::AwaitingDark && !found_at)
      found_at = machine.z_axis().height();
  }
  void layer_done(const LayerRecord& layer) override {
    if (layer.complete) layers[layer.layer] = {layer.exposure_asked, layer.mask_height, masks[layer.layer]};
  }
  void progressed(const PrintProgress& progress) override {
    CHECK_FALSE(machine.light_is_on());
    progresses.push_back(progress);
  }
  void interrupted(const std::string&) override {}
  void light_gone() override {}
  void print_ended(PrintOutcome ended, const std::string& why, PrintPlan) override {
    outcome = ended;
    reason = why;
  }

  VirtualClock clock;
  SimulatedPrinter machine;
  std::vector<PrintProgress> progresses;
  std::map<std::int32_t, Mask> masks;
  std::map<std::int32_t, LitLayer> layers;
  std::optional<PrintOutcome> outcome;
  std::string reason;
  std::optional<Nanometers> found_at;  // height of the plate when its position was known
  Nanometers least{1'000'000'000};     // least known height of the plate
  std::unique_ptr<LayeredPrint> process = std::make_unique<LayeredPrint>(machine, clock, *this);

 private:
  static SimulatedPrinterConfig config(bool homes_upwards) {
    SimulatedPrinterConfig config = testing::small_printer();
    config.axis.homes_upwards = homes_upwards;
    return config;
  }
};

InterruptedPrint interrupted_in(const PrintProgress& print) {
  return {.files = {}, .progress = {.job = "box", .layers = kLayers, .print = print}};
}

}  // namespace

TEST_CASE("A print that was cut at any recorded phase goes on to the same exposures and masks") {
  RecordedPrint whole(true);
  whole.run(std::nullopt);
  REQUIRE(whole.outcome == PrintOutcome::Done);
  REQUIRE(whole.layers.size() == kLayers);
  std::size_t resumed = 0;
  for (std::size_t cut = 1; cut < whole.progresses.size(); ++cut) {
    // A print is cut when a phase begins, or as late as the phase lasts, when a layer may have had its light.
    for (const bool late : {false, true}) {
      for (const bool trusted : {false, true}) {
        RecordedPrint first(!trusted);
        first.run(std::nullopt, cut + (late ? 1 : 0));
        const PrintProgress& last = first.progresses[cut - 1];
        const InterruptedPrint interrupted = interrupted_in(last);
        INFO("cut " << (late ? "late " : "") << "in phase " << name_of(last.phase) << " of layer "
                    << last.layer << ", trusted " << trusted);
        CHECK(last.phase == whole.progresses[cut - 1].phase);
        if (!has_part(last) || !why_not_resumable(interrupted, !trusted, trusted).empty()) continue;
        ++resumed;
        RecordedPrint rest(!trusted);
        rest.run(resume_point(interrupted.progress, trusted));
        CHECK(rest.reason.empty());
        CHECK(rest.outcome == PrintOutcome::Done);
        // No layer is missing, and only the one in which the print was cut may be lit twice.
        std::map<std::int32_t, LitLayer> all = rest.layers;
        all.insert(first.layers.begin(), first.layers.end());
        CHECK(all == whole.layers);
        for (const auto& [layer, lit] : first.layers) {
          CHECK(lit == whole.layers.at(layer));
          CHECK((!rest.layers.contains(layer) || (late && layer == last.layer && !last.exposed)));
        }
        if (!trusted) continue;
        CHECK(rest.least >= last.plate->least);
        CHECK(rest.found_at == last.plate->least + testing::box_plan(1).motion.lift);
      }
    }
  }
  // Each layer but the last has four phases from which a print goes on upwards, and two from which its
  // recorded position can be trusted.
  CHECK(resumed >= 2 * 6 * (kLayers - 1));
}

TEST_CASE("A print that is cut while it is being cancelled does not go on") {
  RecordedPrint print(true);
  print.run(std::nullopt, 6);
  REQUIRE(has_part(print.progresses.back()));
  print.process->cancel();
  const std::size_t before = print.progresses.size();
  while (print.clock.run_next()) {
  }
  REQUIRE(print.outcome == PrintOutcome::Canceled);
  REQUIRE(print.progresses.size() > before);
  for (std::size_t i = before; i < print.progresses.size(); ++i)
    CHECK(why_not_resumable(interrupted_in(print.progresses[i]), true, false).find("cancelled") !=
          std::string::npos);
}

TEST_CASE("An interrupted print goes on only from a position that is known without a move down") {
  PrintProgress print{PrintPhase::BeforeLight,
                      1,
                      Nanometers{50'000},
                      Nanometers{50'000},
                      1s,
                      {},
                      false,
                      PrintProgress::Heights{Nanometers{100'000}, Nanometers{100'000}}};
  CHECK(why_not_resumable(interrupted_in(print), true, false).empty());
  CHECK(why_not_resumable(interrupted_in(print), false, true).empty());
  CHECK(why_not_resumable(interrupted_in(print), false, false).find("resume --trust-position") !=
        std::string::npos);
  InterruptedPrint older = interrupted_in(print);
  older.is_latest = false;
  CHECK(why_not_resumable(older, false, true).find("damaged") != std::string::npos);
  CHECK(why_not_resumable(older, true, false).empty());
  print.plate->most = Nanometers{6'100'000};
  for (const bool trusted : {false, true}) {
    const std::string why = why_not_resumable(interrupted_in(print), false, trusted);
    CHECK(lacking(why, {"the plate was moving", "contourctl rescue", "plate-cleared"}).empty());
    CHECK(why.find("--trust-position") == std::string::npos);
  }
  print.plate.reset();
  CHECK(why_not_resumable(interrupted_in(print), true, true).find("the plate was moving") !=
        std::string::npos);
  move_by_hand(print, std::nullopt);
  CHECK(why_not_resumable(interrupted_in(print), true, false).starts_with("the plate was moved by hand"));
  print.phase = PrintPhase::Lit;
  print.exposed = true;
  print.layer = kLayers - 1;
  CHECK(why_not_resumable(interrupted_in(print), true, false).starts_with("the print was over"));
}

TEST_CASE(
    "A print whose position is lost while its part hangs on the plate ends, and the plate does not move "
    "down") {
  RecordedPrint rest(false);
  rest.run(ResumePoint{2, Nanometers{100'000}, std::nullopt});
  CHECK(rest.outcome == PrintOutcome::Failed);
  CHECK(rest.reason.find("forbids homing") != std::string::npos);
  CHECK(rest.machine.z_axis().inputs().front().edges == 0);
}

TEST_CASE("The seam is described with the depth that a second full exposure adds, at most Dp ln 2") {
  JobProgress progress = interrupted_in({}).progress;
  progress.print.layer = 11;
  progress.print.phase = PrintPhase::BeforeLight;
  CHECK(describe_seam(progress, Micrometers{150}) ==
        "a power cut interrupted the print in layer 12: the layer was lit again in full, and cures up to 104 "
        "um "
        "deeper");
  CHECK(describe_seam(progress, std::nullopt).ends_with("0.69 of the resin's penetration depth"));
  progress.print.phase = PrintPhase::Lowering;
  CHECK(describe_seam(progress, Micrometers{150}) ==
        "a power cut interrupted the print in layer 12: a seam may show there");
  progress.print.exposed = true;
  CHECK(describe_seam(progress, Micrometers{150}) ==
        "a power cut interrupted the print after layer 12: a seam may show there");
}

TEST_CASE("Trust in the recorded height names the height, the time and what two full steps are") {
  JobProgress progress = interrupted_in({}).progress;
  progress.written = std::chrono::system_clock::time_point(1'700'000'000s);
  progress.print.plate = PrintProgress::Heights{Nanometers{600'000}, Nanometers{600'000}};
  const std::string assumed = describe_trust(progress, 800);
  CHECK(assumed.starts_with("the plate has stood at 0.600 mm since 2023-11-14T22:13:20Z"));
  CHECK(assumed.find("within 2 full steps of where it stood (40 um for this screw") != std::string::npos);
}

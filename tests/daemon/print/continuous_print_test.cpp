#include "daemon/print/continuous_print.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <optional>
#include <semaphore>
#include <set>
#include <utility>

#include "core/continuous/gel_front.hpp"
#include "daemon/frames/frame_summary.hpp"
#include "daemon/print/rise_frames.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/models/models.hpp"

namespace {

using C = ContinuousState;

constexpr std::int32_t kFirstLayers = 2;
constexpr std::int32_t kAllLayers = 20;
constexpr MillimetersPerSecond kMasks{0.36};  // 6 um a refresh

// Sections that do not come before they are let through, as if the computer were too slow for them.
class GatedSections final : public SectionSource {
 public:
  void section_at(Nanometers, Contours& contours) const override {
    contours = {};
    if (!closed) return;
    entered.release();
    gate.acquire();
  }
  std::atomic<bool> closed{false};
  mutable std::counting_semaphore<> entered{0}, gate{0};
};

ContourEngine cone_engine(std::shared_ptr<const SectionSource> beside = nullptr) {
  const double height = in_mm(testing::kBoxLayer) * kAllLayers;
  std::vector<PlateModel> models(1);
  models[0].model = std::make_shared<const HeightIndex>(models::cone(2, height, 40));
  models[0].copies = {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})};
  return {std::move(models), EngineSettings{.display = testing::kSmallDisplay}, std::move(beside)};
}

// Returns the plan for a cone of 1 mm: two layers, and a rise of 0.9 mm at up to `speed`.
PrintPlan cone_plan(double speed_mm_s = 0.1, std::shared_ptr<const SectionSource> beside = nullptr) {
  PrintPlan plan = testing::box_plan(kAllLayers);
  plan.job = "cone";
  plan.pixel_area_mm2 = 0.01;
  plan.engine = std::make_unique<ContourEngine>(cone_engine(std::move(beside)));
  const auto point = [](double height_mm, double speed) {
    return RisePoint{Nanometers{std::llround(height_mm * 1e6)}, MillimetersPerSecond{speed}, RiseLimit::Cure};
  };
  PlannedRise rise{.plan = {}, .first_layer = kFirstLayers};
  rise.plan.points = {point(0.1, 0), point(0.15, speed_mm_s), point(0.7, speed_mm_s),
                      point(0.75, speed_mm_s / 4), point(1, 0)};
  plan.rises.emplace().each = {std::move(rise)};
  return plan;
}

// A clock in which threads can take time, as in the real one.
class ThreadedClock final : public Clock {
 public:
  explicit ThreadedClock(VirtualClock& rest) : rest_(rest) {}
  [[nodiscard]] TimePoint now() const override { return rest_.now(); }
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override {
    return rest_.call_at(when, std::move(call));
  }
  [[nodiscard]] bool skips_waiting() const override { return !threads_take_time; }

  bool threads_take_time = false;

 private:
  VirtualClock& rest_;
};

// A display that notes which mask is on the screen, and may show it some refreshes later.
class NotedFrames final : public testing::PlainDisplay {
 public:
  NotedFrames(MaskDisplay& rest, Clock& clock) : rest_(rest), clock_(clock) {}
  [[nodiscard]] Pixels width() const override { return rest_.width(); }
  [[nodiscard]] Pixels height() const override { return rest_.height(); }
  [[nodiscard]] Duration frame() const override { return rest_.frame(); }
  void show(const Mask& mask, Presented done) override {
    ++requested;
    asked_at = clock_.now();
    if (asked) asked();
    const bool is_late = late_by > 0;
    later_ =
        clock_.call_after(late_by * rest_.frame(), [this, mask, is_late, done = std::move(done)]() mutable {
          rest_.show(mask, [this, mask, is_late, done = std::move(done)](std::optional<TimePoint> at) {
            on_screen = mask;
            late_shown += is_late ? 1 : 0;
            done(at);
            if (presented && at) presented(*at);
          });
        });
  }
  void black(Presented done) override { rest_.black(std::move(done)); }
  void black_now() noexcept override {
    later_.reset();
    on_screen.reset();
    rest_.black_now();
  }

  int late_by = 0, requested = 0, late_shown = 0;
  TimePoint asked_at{};
  std::optional<Mask> on_screen;
  std::function<void()> asked;
  std::function<void(TimePoint)> presented;

 private:
  MaskDisplay& rest_;
  Clock& clock_;
  std::unique_ptr<Timer> later_;
};

class ContinuousPrintFixture final : public Machine, public PrintObserver {
 public:
  explicit ContinuousPrintFixture(ContourEngine engine = cone_engine(),
                                  const SimulatedPrinterConfig& config = testing::small_printer())
      : printer(clock, config),
        screen(printer.display(), clock),
        threaded(clock),
        reference(std::move(engine)),
        process(*this, threaded, *this) {
    printer.on_event([this](const MachineEvent& event) {
      if (event.kind == MachineEvent::Kind::Interlock) process.interrupt(event.what);
      if (event.kind == MachineEvent::Kind::Fault) process.fail(event.what);
    });
    screen.presented = [this](TimePoint at) {
      const Nanometers cut = process.shown().cut_at;
      cut_on_screen = cut;
      if (process.continuous_state() == C::Igniting || process.continuous_state() == C::Rising)
        masks.emplace_back(at, *screen.on_screen);
      if (!compares) return;
      if (process.shows_mask() && process.continuous_state() == C::Layering) {
        const Nanometers middle = printer.z_axis().height().value() - testing::kBoxLayer / 2;
        wrong_masks += cut == middle && reference.mask_at(cut) == *screen.on_screen ? 0 : 1;
        ++layers_shown;
      }
      if (process.continuous_state() != C::Rising) return;
      const Nanometers plate = printer.z_axis().height_at(at + screen.frame() / 2).value();
      farthest_cut = std::max(farthest_cut, std::abs((cut - plate).count()));
      wrong_masks += reference.mask_at(cut) == *screen.on_screen ? 0 : 1;
      ++frames;
    };
  }

  [[nodiscard]] ZAxis& z_axis() override { return printer.z_axis(); }
  [[nodiscard]] MaskDisplay& display() override { return screen; }
  [[nodiscard]] Projector& projector() override { return printer.projector(); }
  void on_event(std::function<void(const MachineEvent&)>) override {}
  [[nodiscard]] std::string why_not_ready() const override { return printer.why_not_ready(); }
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  bool step() {
    const bool more = clock.run_next();
    check();
    return more;
  }
  // Checks what holds at every moment.
  void check() {
    const bool lit = printer.light_is_on();
    lit_unknown = lit_unknown || (lit && !process.light_may_be_on());
    lit_black = lit_black || (lit && printer.screen_is_black());
    const Nanometers gels = gelled(lit);
    if (!lit || process.continuous_state() != C::Rising) return;
    farthest_lit = std::max(farthest_lit, std::abs((gels - cut_on_screen).count()));
  }
  // Returns the height at which resin gels; that of the plate, if no resin is given.
  Nanometers gelled(bool lit) {
    const Nanometers plate = printer.z_axis().height().value_or(Nanometers{});
    const Duration time = clock.now() - std::exchange(checked_at, clock.now());
    if (!front) return plate;
    if (lit && was_lit && process.continuous_state() != C::Layering)
      front->add(plate, {time, light_of(white_for(process.settings().rise.light_percent, 1), 1)});
    if (!lit && was_lit) front->forget();
    was_lit = lit;
    return front->height();
  }
  bool run_to(C state) {
    while (process.continuous_state() != state) {
      if (!step()) return false;
    }
    return true;
  }
  // Runs on within a rise, until the plate has reached this height in the light.
  bool run_to_height(double mm) {
    while (!(process.continuous_state() == C::Rising && in_mm(printer.z_axis().height().value()) >= mm)) {
      if (!step()) return false;
    }
    return true;
  }
  void run_out() {
    while (step()) {
    }
  }

  void light_due() override {}
  void state_changed(const PrintState& state) override { states.emplace_back(state.name); }
  void layer_done(const LayerRecord& layer) override { layers.push_back(layer); }
  void frame_over(const FrameRecord& frame) override { recorded.push_back(frame); }
  void progressed(const PrintProgress& now) override { progress.push_back(now); }
  void interrupted(const std::string& what) override { interruptions.push_back(what); }
  void light_gone() override { gone_while_lit = gone_while_lit || printer.light_is_on(); }
  void print_ended(PrintOutcome outcome, const std::string& why, PrintPlan plan) override {
    ends.push_back(outcome);
    reason = why;
    lit_at_end = printer.light_is_on();
    has_plan = plan.engine != nullptr;
  }
  // Returns what was unsafe; empty if nothing was.
  [[nodiscard]] std::string dangers() const {
    std::string all;
    if (lit_unknown) all += "the light was on, but reported as off; ";
    if (lit_black) all += "the light was on without a mask; ";
    if (gone_while_lit || lit_at_end) all += "the light was on, but reported as gone; ";
    const Nanometers farthest = front ? RiseFrames::kFarthestCut : RiseFrames::kFarthest;
    if (farthest_lit > farthest.count())
      all += fmt::format("the mask was {} nm from its height; ", farthest_lit);
    return all;
  }

  VirtualClock clock;
  SimulatedPrinter printer;
  NotedFrames screen;
  ThreadedClock threaded;
  ContourEngine reference;
  std::vector<std::string> states, interruptions;
  std::vector<LayerRecord> layers;
  std::vector<FrameRecord> recorded;
  std::vector<std::pair<TimePoint, Mask>> masks;  // masks of the rise, with their vblanks
  std::vector<PrintProgress> progress;
  std::vector<PrintOutcome> ends;
  std::string reason;
  bool lit_unknown = false, lit_black = false, gone_while_lit = false, lit_at_end = false, has_plan = false;
  std::int64_t farthest_lit = 0, farthest_cut = 0;  // nm
  int wrong_masks = 0, frames = 0, layers_shown = 0;
  bool compares = true;  // the masks
  Nanometers cut_on_screen{};
  std::optional<GelFront> front;
  TimePoint checked_at{};
  bool was_lit = false;
  ContinuousPrint process;
};

constexpr C kRisingStates[] = {C::Lowering,  C::Settling, C::Showing, C::Igniting, C::Rising, C::Braking,
                               C::Darkening, C::Lifting,  C::Paused,  C::Parking,  C::Ending};

// Brings a print into a state.
void bring_to(ContinuousPrintFixture& fixture, C state) {
  fixture.process.start(cone_plan());
  if (state == C::Braking || state == C::Paused) {
    REQUIRE(fixture.run_to_height(0.3));
    fixture.process.pause();
  }
  REQUIRE(fixture.run_to(state));
}

}  // namespace

TEST_CASE("A continuous print prints its first layers, then rises in the light to its end") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
  CHECK(fixture.has_plan);
  CHECK(fixture.interruptions.empty());
  CHECK(std::ranges::count(fixture.states, "exposing") == kFirstLayers);
  CHECK(std::ranges::count(fixture.states, "rising") == 1);
  CHECK(fixture.states.back() == "idle");
  CHECK(std::ranges::count(fixture.states, "idle") == 1);
  CHECK(fixture.printer.z_axis().height() == fixture.printer.z_axis().travel());

  // The rise's slices have the rise's whole time of light.
  REQUIRE(fixture.layers.size() == kAllLayers);
  Duration lit{};
  for (std::size_t i = 0; i < fixture.layers.size(); ++i) {
    CAPTURE(i);
    const LayerRecord& layer = fixture.layers[i];
    CHECK(layer.layer == static_cast<std::int32_t>(i));
    CHECK(layer.complete);
    CHECK(layer.bottom == testing::kBoxLayer * static_cast<std::int64_t>(i));
    CHECK(layer.thickness == testing::kBoxLayer);
    CHECK(layer.mask_height == layer.bottom + layer.thickness / 2);
    if (i < kFirstLayers) continue;
    lit += layer.exposure_most;
    CHECK(layer.frames.shown >= 15);  // at 1.7 um a refresh, each second one has changed by 2 um
    CHECK(layer.frames.missed == 0);
    // A slice's area is the mean of its masks', so that volumes are right: the middle section's, but for the
    // last mask step.
    const double middle_mm2 =
        fixture.reference.mask_at(layer.mask_height).lit_area() * cone_plan().pixel_area_mm2;
    CHECK(layer.area_mm2 == Approx(middle_mm2).margin(0.2));
  }
  const auto planned = std::chrono::duration_cast<Duration>(duration(cone_plan().rises->each[0].plan));
  CHECK(std::chrono::abs(lit - planned) < 100ms);  // light on and off at the ends
}

TEST_CASE("Each mask that a rise shows is the core's mask for the plate's height at its refresh's middle") {
  for (const double speed : {0.02, 0.1, 0.11}) {
    CAPTURE(speed);
    ContinuousPrintFixture fixture;
    fixture.process.start(cone_plan(speed));
    REQUIRE(fixture.run_to(C::Rising));
    REQUIRE(fixture.run_to(C::Parking));
    CHECK(fixture.frames > 250);  // 0.9 mm, in steps of up to twice 1.8 um
    CHECK(fixture.wrong_masks == 0);
    CHECK(fixture.farthest_cut == 0);  // the simulated axis and display keep their times exactly
    CHECK(fixture.dangers() == "");
    CHECK(frame_figures(fixture.layers).missed == 0);
    CHECK(frame_figures(fixture.layers).farthest.count() == fixture.farthest_cut);
  }
}

TEST_CASE("Each mask of a rise is on record with its heights, refreshes and light") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to_height(0.4));
  fixture.process.pause();
  REQUIRE(fixture.run_to(C::Paused));
  fixture.process.resume();
  fixture.run_out();
  REQUIRE(fixture.ends == std::vector{PrintOutcome::Done});

  const std::vector<FrameRecord>& frames = fixture.recorded;
  REQUIRE(frames.size() == fixture.masks.size());
  const FrameSummary summary = summary_of(frames);
  CHECK(summary.rises == 2);
  CHECK(summary.missed == 0);
  CHECK(summary.nearest.way == Nanometers{});  // the simulated axis and display keep their times
  CHECK(summary.farthest.way == Nanometers{});
  CHECK(summary.longest.way < Nanometers{4'000});  // two refreshes of 1.7 um
  CHECK(summary.lowest == Nanometers{100'000});
  CHECK(std::abs((summary.highest - Nanometers{1'000'000}).count()) < 10'000);
  Duration lit{};
  for (const LayerRecord& layer : fixture.layers)
    if (layer.rises) lit += layer.exposure_asked;
  CHECK(std::chrono::abs(lit - summary.lit) < 1ms);

  const Duration refresh = fixture.screen.frame();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CAPTURE(i);
    const FrameRecord& frame = frames[i];
    CHECK(frame.shown == fixture.masks[i].first);
    CHECK(fixture.reference.mask_at(frame.cut) == fixture.masks[i].second);
    CHECK((frame.layer >= kFirstLayers && frame.layer < kAllLayers));
    CHECK(frame.begins == (i == 0 || frames[i - 1].first > frames[i].last ||
                           frame.shown - frames[i - 1].shown > 100 * refresh));
    CHECK(frame.last >= frame.first);
    if (i == 0 || frame.begins) continue;
    // Masks follow each other without a gap, in time and light.
    CHECK(frame.shown == frames[i - 1].shown + frames[i - 1].refreshes * refresh);
    CHECK(frame.first > frames[i - 1].last);
    if (i + 1 < frames.size() && !frames[i + 1].begins) CHECK(frame.lit == frame.refreshes * refresh);
  }
}

TEST_CASE("A mask that came late counts as missed for the one that stayed") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan(0.05));
  REQUIRE(fixture.run_to_height(0.3));
  const std::size_t before = fixture.recorded.size();
  fixture.screen.late_by = 1;
  REQUIRE(fixture.run_to_height(0.31));
  fixture.screen.late_by = 0;
  fixture.run_out();
  std::uint32_t missed = 0;
  for (std::size_t i = before; i < fixture.recorded.size(); ++i)
    missed += fixture.recorded[i].missed;
  CHECK(missed > 0);
  CHECK(missed == frame_figures(fixture.layers).missed);
}

TEST_CASE("A dry rise records its masks without light") {
  ContinuousPrintFixture fixture;
  PrintPlan plan = cone_plan();
  plan.dry = true;
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.recorded.size() > 250);
  CHECK(summary_of(fixture.recorded).lit == Duration{0});
}

TEST_CASE("A rise at the highest speed that masks allow, 2 um a refresh, is not interrupted") {
  ContinuousPrintFixture fixture;
  PrintPlan plan = cone_plan(0.12);
  std::vector<RisePoint>& points = plan.rises->each[0].plan.points;
  points[1].height = points[0].height + Nanometers{10'000};
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.interruptions == std::vector<std::string>{});
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
}

TEST_CASE("A plan without a rise is printed layer by layer, as by the layered mode alone") {
  ContinuousPrintFixture fixture;
  PrintPlan plan = cone_plan();
  plan.rises.reset();
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.layers.size() == kAllLayers);
  CHECK(std::ranges::count(fixture.states, "rising") == 0);
  CHECK(std::ranges::count(fixture.states, "idle") == 1);
}

TEST_CASE("In every state of a rise, a cancellation turns the light off at once and parks the plate") {
  for (const C state : kRisingStates) {
    CAPTURE(name_of(state));
    ContinuousPrintFixture fixture;
    bring_to(fixture, state);
    const bool ends = state == C::Parking || state == C::Ending;
    CHECK(fixture.process.can_cancel() == !ends);
    fixture.process.cancel();
    CHECK_FALSE(fixture.process.shows_mask());
    CHECK(fixture.printer.screen_is_black());
    fixture.run_out();
    CHECK(fixture.ends == std::vector{ends ? PrintOutcome::Done : PrintOutcome::Canceled});
    CHECK(fixture.printer.z_axis().height() == fixture.printer.z_axis().travel());
    CHECK(fixture.dangers() == "");
  }
}

TEST_CASE("In every state of a rise, a fault ends the print with the light off") {
  for (const C state : kRisingStates) {
    CAPTURE(name_of(state));
    ContinuousPrintFixture fixture;
    bring_to(fixture, state);
    fixture.process.fail("the chip is gone");
    CHECK(fixture.printer.screen_is_black());
    fixture.run_out();
    const bool ended = state == C::Ending;
    CHECK(fixture.ends == std::vector{ended ? PrintOutcome::Done : PrintOutcome::Failed});
    CHECK(fixture.reason == (ended ? "" : "the chip is gone"));
    CHECK(fixture.dangers() == "");
  }
}

TEST_CASE(
    "In every state of a rise, an interruption turns dark and waits, and the print resumes to its end") {
  for (const C state : kRisingStates) {
    for (const bool by_user : {false, true}) {
      CAPTURE(name_of(state), by_user);
      ContinuousPrintFixture fixture;
      bring_to(fixture, state);
      by_user ? fixture.process.pause() : fixture.process.interrupt("the lid was opened");
      CHECK((by_user || fixture.printer.screen_is_black()));
      fixture.run_out();
      if (fixture.ends.empty()) {
        CHECK(fixture.process.continuous_state() == C::Paused);
        CHECK_FALSE(fixture.printer.light_is_on());
        CHECK(fixture.process.interruption() == (by_user ? "" : "the lid was opened"));
        REQUIRE(fixture.process.can_resume());
        fixture.process.resume();
        fixture.run_out();
      } else {
        CHECK((state == C::Darkening || state == C::Lifting || state == C::Parking || state == C::Ending));
      }
      CHECK(fixture.ends == std::vector{PrintOutcome::Done});
      CHECK(fixture.layers.size() == kAllLayers);
      CHECK(fixture.dangers() == "");
      CHECK(fixture.wrong_masks == 0);
    }
  }
}

TEST_CASE("A pause within a rise takes effect at once, and the rise goes on from the same height") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to_height(0.5));
  CHECK(fixture.process.next_pause() == "now");
  const Nanometers paused_at = fixture.printer.z_axis().height().value();
  fixture.process.pause();
  REQUIRE(fixture.run_to(C::Lifting));
  REQUIRE(fixture.run_to(C::Paused));
  CHECK(in_mm(fixture.printer.z_axis().height().value()) > 30);
  fixture.process.resume();
  REQUIRE(fixture.run_to(C::Rising));
  // 0.1 mm/s is braked within less than a microstep.
  CHECK(std::abs((fixture.printer.z_axis().height().value() - paused_at).count()) <= 1'250);
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.wrong_masks == 0);
  CHECK(fixture.dangers() == "");
}

TEST_CASE("A pause that was planned ahead takes effect within the rise, at its layer or height") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  SECTION("Planned in the first layers") {
    fixture.process.pause_at(testing::kBoxLayer * 8);
    REQUIRE(fixture.run_to_height(0.2));
  }
  SECTION("Planned in the rise") {
    REQUIRE(fixture.run_to_height(0.2));
    fixture.process.pause_at(std::int32_t{8});
  }
  REQUIRE(fixture.process.planned_pause());
  REQUIRE(fixture.run_to(C::Braking));
  const double height = in_mm(fixture.printer.z_axis().height().value());
  CHECK(height >= 8 * in_mm(testing::kBoxLayer));
  CHECK(height < 8.2 * in_mm(testing::kBoxLayer));  // a refresh later, at 0.1 mm/s
  CHECK_FALSE(fixture.process.planned_pause());
  REQUIRE(fixture.run_to(C::Paused));
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
}

TEST_CASE("A planned pause is withdrawn by resume() within the rise") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to_height(0.2));
  fixture.process.pause_at(std::int32_t{8});
  REQUIRE(fixture.process.can_resume());
  fixture.process.resume();
  CHECK_FALSE(fixture.process.planned_pause());
  fixture.run_out();
  CHECK(std::ranges::find(fixture.states, "braking") == fixture.states.end());
}

TEST_CASE(
    "What is set in the first layers or the rise of a continuous print holds for the moves that follow") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to(C::Layering));
  PrintSettings settings = fixture.process.settings();
  settings.motion.lift = Nanometers{2'500'000};
  SECTION("In the last of the first layers") {
    while (fixture.process.layer() + 1 < kFirstLayers)
      REQUIRE(fixture.step());
    fixture.process.set(settings);
    REQUIRE(fixture.run_to(C::Rising));
  }
  SECTION("In the rise") {
    REQUIRE(fixture.run_to(C::Rising));
    fixture.process.set(settings);
  }
  CHECK(fixture.process.settings().motion.lift == Nanometers{2'500'000});
  CHECK(fixture.process.why_fixed("lift").empty());
  CHECK_FALSE(fixture.process.why_fixed("exposure").empty());
  CHECK_FALSE(fixture.process.why_fixed("copies").empty());
  CHECK(contract_broken_by([&] { fixture.process.exclude({}); }) ==
        "copies are left dark while layers are printed");
}

TEST_CASE("A copy that is excluded in the last layer before a rise is dark from the rise on") {
  ContinuousPrintFixture fixture;
  PrintPlan plan = cone_plan();
  const double height = in_mm(testing::kBoxLayer) * kAllLayers;
  const auto box =
      std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, static_cast<float>(height)}));
  const DisplayGeometry& display = testing::kSmallDisplay;
  plan.engine = std::make_unique<ContourEngine>(
      std::vector{PlateModel{
          {box}, {PixelMap::true_scale(display, {2, 0.5}), PixelMap::true_scale(display, {-1, 0.5})}}},
      EngineSettings{.display = display});
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to(C::Layering));
  while (fixture.process.layer() + 1 < kFirstLayers)
    REQUIRE(fixture.step());
  fixture.process.exclude({0, 1, {}});
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  REQUIRE(fixture.layers.size() == kAllLayers);
  for (const LayerRecord& layer : fixture.layers)
    CHECK(layer.area_mm2 == Approx(layer.layer < kFirstLayers ? 2 : 1));
}

TEST_CASE("A lid that opens within a rise turns the light off at once") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to_height(0.5));
  REQUIRE(fixture.printer.light_is_on());
  const TimePoint opened = fixture.clock.now();
  fixture.printer.open_lid();
  CHECK(fixture.printer.screen_is_black());
  while (fixture.printer.light_is_on())
    REQUIRE(fixture.step());
  CHECK(fixture.clock.now() - opened <= 20ms);  // the projector's reply
  fixture.run_out();
  CHECK(fixture.process.continuous_state() == C::Paused);
}

TEST_CASE("A display that shows masks too late counts as missed, and interrupts the rise before 5 um") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  REQUIRE(fixture.run_to_height(0.4));
  fixture.screen.late_by = 1;
  REQUIRE(fixture.run_to_height(0.5));
  CHECK(fixture.interruptions.empty());
  fixture.screen.late_by = 6;
  fixture.run_out();
  CHECK(frame_figures(fixture.layers).missed > 10);
  REQUIRE(fixture.interruptions.size() == 1);
  CHECK(testing::lacking(fixture.interruptions[0], {"too old", "5 um"}).empty());
  CHECK(fixture.process.continuous_state() == C::Paused);
  CHECK(fixture.dangers() == "");
  fixture.screen.late_by = 0;
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
}

TEST_CASE("A mask is begun as soon as the one before was passed to the display, and has a whole refresh") {
  const auto gate = std::make_shared<GatedSections>();
  ContinuousPrintFixture fixture;
  PrintPlan plan = cone_plan(0.1, gate);
  plan.rises->mask_step = Nanometers{1'000};  // less than the plate rises in a refresh
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to_height(0.2));
  // No mask is being cut while one is passed to the display.
  fixture.screen.asked = [&] { gate->closed = fixture.threaded.threads_take_time = true; };
  for (int mask = 0; mask < 10; ++mask) {
    CAPTURE(mask);
    const int shown = fixture.screen.requested;
    while (fixture.screen.requested == shown)
      REQUIRE(fixture.step());
    REQUIRE(gate->entered.try_acquire_for(10s));
    const TimePoint begun = fixture.clock.now();
    while (fixture.clock.now() < begun + fixture.screen.frame() / 2)
      REQUIRE(fixture.step());
    gate->gate.release();
    fixture.threaded.threads_take_time = false;
  }
  fixture.screen.asked = nullptr;
  gate->closed = false;
  fixture.run_out();
  CHECK(frame_figures(fixture.layers).missed == 0);
}

TEST_CASE("A mask that takes too long is missed: the loop does not wait, and the rise is interrupted dark") {
  const auto gate = std::make_shared<GatedSections>();
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan(0.1, gate));
  REQUIRE(fixture.run_to_height(0.2));
  gate->closed = fixture.threaded.threads_take_time = true;
  while (fixture.process.continuous_state() == C::Rising)
    REQUIRE(fixture.step());
  gate->closed = fixture.threaded.threads_take_time = false;
  gate->gate.release(1'000);
  REQUIRE(fixture.interruptions.size() == 1);
  CHECK(testing::lacking(fixture.interruptions[0], {"masks were missed"}).empty());
  CHECK(fixture.dangers() == "");
  fixture.process.cancel();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
  CHECK(frame_figures(fixture.layers).missed >= 2);
}

TEST_CASE("A plate that a disturbance has stopped, or an axis that refuses the rise, turns the light off") {
  SECTION("Stopped") {
    ContinuousPrintFixture fixture;
    fixture.process.start(cone_plan());
    REQUIRE(fixture.run_to_height(0.5));
    fixture.printer.z_axis().stop();
    fixture.run_out();
    CHECK(fixture.process.continuous_state() == C::Paused);
    CHECK(fixture.interruptions == std::vector<std::string>{"a disturbance has stopped the plate"});
    CHECK(fixture.dangers() == "");
    fixture.process.resume();
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  }
  SECTION("Refused") {
    ContinuousPrintFixture fixture;
    fixture.process.start(cone_plan(2.6));
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
    CHECK(fixture.reason == "the plate did not rise: the axis cannot follow the planned rise");
    CHECK(fixture.dangers() == "");
  }
}

TEST_CASE("The first layers of a continuous print are paused, interrupted and cancelled as in any print") {
  ContinuousPrintFixture fixture;
  fixture.process.start(cone_plan());
  while (fixture.process.state().name != "exposing")
    REQUIRE(fixture.step());
  const Duration left = fixture.process.time_left();
  SECTION("Interrupted") {
    fixture.process.interrupt("the lid was opened");
    fixture.run_out();
    CHECK(fixture.process.state().name == "paused");
    CHECK(fixture.process.interruption() == "the lid was opened");
    fixture.process.resume();
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  }
  SECTION("Cancelled") {
    fixture.process.cancel();
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
  }
  SECTION("Failed") {
    fixture.process.fail("the chip is gone");
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
    CHECK(fixture.reason == "the chip is gone");
  }
  SECTION("Neither: the time left was right") {
    const TimePoint then = fixture.clock.now();
    fixture.run_out();
    // The first mask, light on and off, the look up after the rise and the settling before it.
    CHECK(std::chrono::abs(fixture.clock.now() - then - left) < 12s);
  }
  CHECK(fixture.dangers() == "");
}

namespace {

// Returns the masks of two stems with a flange between them, from 0.4 to 0.6 mm.
ContourEngine flange_engine() {
  std::vector<PlateModel> models(1);
  models[0].model = std::make_shared<const HeightIndex>(models::together(
      {models::box({-1, -1, 0}, {1, 1, 0.4F}), models::box({-2.5F, -2, 0.4F}, {2.5F, 2, 0.6F}),
       models::box({-0.8F, -0.8F, 0.6F}, {0.8F, 0.8F, 1})}));
  models[0].copies = {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})};
  return {std::move(models), EngineSettings{.display = testing::kSmallDisplay}};
}

constexpr Duration kOxygenRest = 60s;

// The numbers of layers up to which the parts of a print reach: layers, a rise, layers, a rise, a rise after
// a rest, layers.
using Parts = std::array<int, 6>;
constexpr Parts kFlange{2, 8, 12, 16, 19, kAllLayers};
constexpr Parts kShort{1, 3, 4, 5, 6, 7};

PrintPlan parts_plan(const Parts& parts = kFlange) {
  PrintPlan plan = testing::box_plan(parts.back());
  plan.job = "flange";
  plan.engine = std::make_unique<ContourEngine>(flange_engine());
  const auto rise = [](int first_layer, int end, Duration rest) {
    const Nanometers bottom = testing::kBoxLayer * first_layer, top = testing::kBoxLayer * end;
    const MillimetersPerSecond rest_speed{0}, speed{0.1};
    return PlannedRise{{{{bottom, rest_speed, RiseLimit::Machine},
                         {bottom + Nanometers{10'000}, speed, RiseLimit::Cure},
                         {top - Nanometers{10'000}, speed, RiseLimit::Machine},
                         {top, rest_speed, RiseLimit::Machine}}},
                       first_layer,
                       rest};
  };
  plan.rises.emplace().each = {rise(parts[0], parts[1], 0s), rise(parts[2], parts[3], 0s),
                               rise(parts[3], parts[4], kOxygenRest)};
  return plan;
}
constexpr std::ptrdiff_t kLayersOfParts = 7;

// Checks that every layer was printed once, with masks that were right, and without danger.
void check_whole(const ContinuousPrintFixture& fixture, int layers = kAllLayers) {
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
  CHECK(fixture.wrong_masks == 0);
  REQUIRE(fixture.layers.size() == static_cast<std::size_t>(layers));
  for (std::size_t i = 0; i < fixture.layers.size(); ++i) {
    CAPTURE(i);
    CHECK(fixture.layers[i].layer == static_cast<std::int32_t>(i));
    CHECK(fixture.layers[i].bottom == testing::kBoxLayer * static_cast<std::int64_t>(i));
    CHECK(fixture.layers[i].complete);
  }
}

}  // namespace

TEST_CASE("A print with a wide middle section rises, is layered there, rises again, rests and rises on") {
  ContinuousPrintFixture fixture(flange_engine());
  fixture.process.start(parts_plan());
  while (fixture.process.state().name != "exposing")
    REQUIRE(fixture.step());
  const TimePoint then = fixture.clock.now();
  const Duration left = fixture.process.time_left();
  REQUIRE(fixture.run_to(C::Recovering));
  const TimePoint rest_began = fixture.clock.now();
  while (fixture.process.continuous_state() == C::Recovering) {
    CHECK_FALSE(fixture.printer.light_is_on());
    REQUIRE(fixture.step());
  }
  CHECK(fixture.clock.now() - rest_began == kOxygenRest);
  fixture.run_out();
  check_whole(fixture);
  CHECK(fixture.interruptions.empty());
  CHECK(std::ranges::count(fixture.states, "rising") == 3);
  CHECK(std::ranges::count(fixture.states, "recovering") == 1);
  CHECK(std::ranges::count(fixture.states, "exposing") == kLayersOfParts);
  CHECK(std::ranges::count(fixture.states, "idle") == 1);
  CHECK(fixture.layers_shown == kLayersOfParts);
  CHECK(fixture.frames > 250);  // 0.65 mm, in steps of up to twice 1.7 um
  CHECK(fixture.farthest_cut == 0);
  // The first masks, and light on and off.
  CHECK(std::chrono::abs(fixture.clock.now() - then - left) < 5s);
}

TEST_CASE(
    "In every state of a print with several parts, light goes off at once, and resumed prints are whole") {
  enum class What { Cancel, Pause, Lid, Fault };
  // The first change into each state of each part from the end of the first rise on.
  std::vector<std::size_t> changes;
  {
    ContinuousPrintFixture whole(flange_engine());
    whole.process.start(parts_plan(kShort));
    whole.run_out();
    std::set<std::pair<std::string, std::ptrdiff_t>> seen;
    for (std::size_t i = 0; i + 1 < whole.states.size(); ++i) {
      const auto end = whole.states.begin() + static_cast<std::ptrdiff_t>(i);
      const std::ptrdiff_t rises = std::count(whole.states.begin(), end, "rising");
      if (rises > 0 && seen.emplace(*end, rises).second) changes.push_back(i + 1);
    }
  }
  for (const std::size_t change : changes) {
    for (const What what : {What::Cancel, What::Pause, What::Lid, What::Fault}) {
      ContinuousPrintFixture fixture(flange_engine());
      fixture.compares = false;
      fixture.process.start(parts_plan(kShort));
      while (fixture.states.size() < change)
        REQUIRE(fixture.step());
      const std::string state = fixture.states.back();
      CAPTURE(change, state, static_cast<int>(what));
      const bool ended = state == "ending", parks = ended || state == "parking";
      const TimePoint when = fixture.clock.now();
      if (what == What::Cancel) fixture.process.cancel();
      if (what == What::Pause) fixture.process.pause();
      if (what == What::Lid) fixture.printer.open_lid();
      if (what == What::Fault) fixture.process.fail("the chip is gone");
      if (what != What::Pause) {
        CHECK(fixture.printer.screen_is_black());
        while (fixture.printer.light_is_on())
          REQUIRE(fixture.step());
        CHECK(fixture.clock.now() - when <= 20ms);  // the projector's reply
      }
      fixture.run_out();
      if (what == What::Fault) {
        CHECK(fixture.ends == std::vector{ended ? PrintOutcome::Done : PrintOutcome::Failed});
        CHECK(fixture.dangers() == "");
        continue;
      }
      if (what == What::Cancel) {
        CHECK(fixture.ends == std::vector{parks ? PrintOutcome::Done : PrintOutcome::Canceled});
        CHECK(fixture.dangers() == "");
        continue;
      }
      if (fixture.ends.empty()) {
        CHECK_FALSE(fixture.printer.light_is_on());
        if (what == What::Lid) fixture.printer.close_lid();
        REQUIRE(fixture.process.can_resume());
        fixture.process.resume();
        fixture.run_out();
      }
      check_whole(fixture, kShort.back());
    }
  }
}

TEST_CASE("A pause while the window recovers counts for its rest, and one at a rise's end waits there") {
  ContinuousPrintFixture fixture(flange_engine());
  fixture.process.start(parts_plan());
  SECTION("Recovering") {
    REQUIRE(fixture.run_to(C::Recovering));
    const TimePoint began = fixture.clock.now();
    fixture.process.pause();
    REQUIRE(fixture.run_to(C::Paused));
    fixture.process.resume();
    CHECK(fixture.process.continuous_state() == C::Recovering);
    REQUIRE(fixture.run_to(C::Lowering));
    CHECK(fixture.clock.now() - began >= kOxygenRest);
    CHECK(fixture.clock.now() - began < kOxygenRest + 1s);
  }
  SECTION("Planned for the top of the first rise") {
    REQUIRE(fixture.run_to(C::Rising));
    fixture.process.pause_at(std::int32_t{8});
    REQUIRE(fixture.run_to(C::Paused));
    CHECK(fixture.process.layer() == 8);
    CHECK(fixture.layers.size() == 8);
    fixture.process.resume();
    CHECK(fixture.process.state().name == "awaiting dark");
  }
  SECTION("Planned in a rise for a layer of the flange") {
    REQUIRE(fixture.run_to(C::Rising));
    fixture.process.pause_at(std::int32_t{10});
    while (fixture.process.state().name != "paused")
      REQUIRE(fixture.step());
    CHECK(fixture.layers.size() == 10);
    CHECK_FALSE(fixture.process.planned_pause());
    fixture.process.resume();
  }
  fixture.run_out();
  check_whole(fixture);
}

TEST_CASE(
    "Between two parts of a print, it is known to the layer what is printed, and a print goes on there") {
  // Resumes the print from what was reported last in a state, as after a power cut.
  const auto resumed_from = [](C state, int rise) {
    ContinuousPrintFixture cut(flange_engine());
    cut.process.start(parts_plan());
    for (int i = 0; i < rise; ++i) {
      REQUIRE(cut.run_to(C::Rising));
      REQUIRE(cut.run_to(C::Lifting));
    }
    REQUIRE(cut.run_to(state));
    const PrintProgress last = cut.progress.back();
    REQUIRE(last.exposed);
    ContinuousPrintFixture fixture(flange_engine());
    PrintPlan plan = parts_plan();
    plan.resume = ResumePoint{.layer = last.layer + 1, .bottom = last.bottom + last.thickness};
    fixture.layers = {cut.layers.begin(), cut.layers.begin() + last.layer + 1};
    // The axis of the simulated printer homes downwards, so it trusts a height above the part.
    plan.resume->height = Nanometers{5'000'000};
    fixture.process.start(std::move(plan));
    fixture.run_out();
    check_whole(fixture);
    return std::pair(last, std::ranges::count(fixture.states, "rising"));
  };
  SECTION("After the first layers: the print rises next") {
    ContinuousPrintFixture fixture(flange_engine());
    PrintPlan plan = parts_plan();
    plan.resume = ResumePoint{2, testing::kBoxLayer * 2, Nanometers{5'000'000}};
    fixture.process.start(std::move(plan));
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
    CHECK(fixture.dangers() == "");
    CHECK(fixture.layers.size() == kAllLayers - 2);
    CHECK(fixture.layers.front().layer == 2);
    CHECK(std::ranges::count(fixture.states, "rising") == 3);
  }
  SECTION("On the way up from the first rise: layers follow") {
    const auto [last, rises] = resumed_from(C::Lifting, 1);
    CHECK(last.phase == PrintPhase::Lifting);
    CHECK(last.layer == 7);
    CHECK(rises == 2);
  }
  SECTION("In the rest: a rise follows") {
    const auto [last, rises] = resumed_from(C::Recovering, 2);
    CHECK(last.phase == PrintPhase::Lit);
    CHECK(last.layer == 15);
    CHECK(is_at_rest(last));
    CHECK(rises == 1);
  }
}

TEST_CASE("A dry run makes all moves and masks of a print in layers and rises, and never has light") {
  ContinuousPrintFixture fixture(flange_engine());
  PrintPlan plan = parts_plan();
  plan.dry = true;
  fixture.process.start(std::move(plan));
  bool lit = false;
  while (fixture.step())
    lit = lit || fixture.printer.light_is_on();
  CHECK_FALSE(lit);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.frames > 100);
  CHECK(fixture.wrong_masks == 0);
  CHECK(std::ranges::count(fixture.states, "rising") == 3);
  CHECK(std::ranges::none_of(fixture.layers, &LayerRecord::complete));
}

namespace {

// Lets the display show a mask of a rise a refresh too late, at a height.
void miss_a_mask(ContinuousPrintFixture& fixture, double at_mm) {
  REQUIRE(fixture.run_to_height(at_mm));
  fixture.screen.late_by = 1;
  for (const int before = fixture.screen.late_shown; fixture.screen.late_shown == before;)
    REQUIRE(fixture.step());
  fixture.screen.late_by = 0;
}

// Returns the plan for the flange, in whose rises a missed mask has a consequence.
PrintPlan strict_plan(MissedMasks missed) {
  PrintPlan plan = parts_plan();
  plan.rises->missed = missed;
  plan.rises->slowest = MillimetersPerSecond{0.06};
  return plan;
}

// Returns the plate's mean speed over the next half a second, in mm/s.
double speed_now(ContinuousPrintFixture& fixture) {
  const Nanometers from = fixture.printer.z_axis().height().value();
  for (const TimePoint until = fixture.clock.now() + 500ms; fixture.clock.now() < until;)
    REQUIRE(fixture.step());
  return in_mm(fixture.printer.z_axis().height().value() - from) / 0.5;
}

}  // namespace

TEST_CASE("A missed mask slows the plate down in the light, if the profile wants that, but only so far") {
  ContinuousPrintFixture fixture(flange_engine());
  fixture.process.start(strict_plan(MissedMasks::Slow));
  REQUIRE(fixture.run_to_height(0.12));
  CHECK(speed_now(fixture) == Approx(0.1).margin(0.005));
  miss_a_mask(fixture, 0.18);
  CHECK(fixture.process.continuous_state() == C::Slowing);
  CHECK(fixture.printer.light_is_on());
  REQUIRE(fixture.run_to(C::Rising));
  CHECK(fixture.printer.light_is_on());
  // The ramp to the speed takes up to 0.15 s of the half.
  CHECK(speed_now(fixture) == Approx(0.075).margin(0.012));
  miss_a_mask(fixture, 0.30);
  REQUIRE(fixture.run_to(C::Rising));
  CHECK(speed_now(fixture) == Approx(0.06).margin(0.01));
  miss_a_mask(fixture, 0.37);
  REQUIRE(fixture.run_to(C::Layering));
  // The next rise is as slow.
  REQUIRE(fixture.run_to_height(0.65));
  CHECK(speed_now(fixture) == Approx(0.06).margin(0.005));
  fixture.run_out();
  check_whole(fixture);
  CHECK(fixture.interruptions.empty());
  const FrameFigures frames = frame_figures(fixture.layers);
  CHECK(frames.slowed == 2);
  CHECK(frames.missed >= 3);
}

TEST_CASE("A missed mask turns the light off and pauses the print, if the profile wants that") {
  ContinuousPrintFixture fixture(flange_engine());
  fixture.process.start(strict_plan(MissedMasks::Pause));
  miss_a_mask(fixture, 0.2);
  fixture.run_out();
  CHECK(fixture.process.continuous_state() == C::Paused);
  REQUIRE(fixture.interruptions.size() == 1);
  CHECK(testing::lacking(fixture.interruptions[0], {"a mask was missed at 0.2"}).empty());
  fixture.process.resume();
  fixture.run_out();
  check_whole(fixture);
  CHECK(frame_figures(fixture.layers).missed > 0);
}

TEST_CASE(
    "While the plate is slowed down, a cancel, a pause, the lid and a fault turn the light off at once") {
  for (int what = 0; what < 4; ++what) {
    CAPTURE(what);
    ContinuousPrintFixture fixture(flange_engine());
    fixture.process.start(strict_plan(MissedMasks::Slow));
    miss_a_mask(fixture, 0.2);
    REQUIRE(fixture.process.continuous_state() == C::Slowing);
    const TimePoint when = fixture.clock.now();
    if (what == 0) fixture.process.cancel();
    if (what == 1) fixture.process.pause();
    if (what == 2) fixture.printer.open_lid();
    if (what == 3) fixture.process.fail("the chip is gone");
    CHECK(fixture.printer.screen_is_black());
    while (fixture.printer.light_is_on())
      REQUIRE(fixture.step());
    CHECK(fixture.clock.now() - when <= 20ms);
    fixture.run_out();
    if (what == 1 || what == 2) {
      CHECK(fixture.process.continuous_state() == C::Paused);
      if (what == 2) fixture.printer.close_lid();
      fixture.process.resume();
      fixture.run_out();
      check_whole(fixture);
    }
    CHECK(fixture.dangers() == "");
    CHECK(fixture.ends == std::vector{what == 0   ? PrintOutcome::Canceled
                                      : what == 3 ? PrintOutcome::Failed
                                                  : PrintOutcome::Done});
  }
}

namespace {

// Returns a plan for the cone whose rise follows from slabs: at most 20 mm/h, with a margin of 4 the cure
// allows 55.
PrintPlan changeable_plan() {
  PrintPlan plan = cone_plan();
  std::vector<RiseSlab> slabs;
  for (const std::int64_t um : {100, 400, 700, 1000})
    slabs.push_back({Nanometers{um * 1000}, Millimeters{1}});
  PlannedRises& rises = *plan.rises;
  rises.slowest = MillimetersPerSecond{5.0 / 3600};
  rises.bounds = {.lit = {{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}},
                  .margin = 4,
                  .refill = {.viscosity_pa_s = 0.2, .pressure_kpa = 50},
                  .fastest = MillimetersPerSecond{0.1},
                  .slowest = rises.slowest,
                  .acceleration = MillimetersPerSecondSquared{5},
                  .window = std::chrono::minutes{20}};
  rises.settings = planned_settings(rises.bounds);
  rises.settings.speed_mm_h = 20;
  rises.slabs = std::make_shared<const std::vector<RiseSlab>>(std::move(slabs));
  const RiseChange as_planned{rises.each[0].plan, Nanometers{100'000}};
  rises.each[0].plan =
      change_rise(*rises.slabs, as_planned, bounds_with(rises.bounds, rises.gamma, rises.settings)).plan;
  return plan;
}

// Changes the rises that are left; returns the reason if that is not possible.
std::string change(ContinuousPrintFixture& fixture, const RiseSettings& settings) {
  const std::optional<RisesAhead> ahead = fixture.process.rises_ahead();
  if (!ahead) return "no rise is left";
  const auto changed = change_rises(*ahead, settings);
  if (const auto* const refusal = std::get_if<std::string>(&changed)) return *refusal;
  fixture.process.change(std::get<ChangedRises>(changed));
  return "";
}

// Runs on for some seconds and returns the plate's mean speed, in mm/h, to half a mm/h: a microstep in ten
// seconds. The light must stay on.
double speed_after(ContinuousPrintFixture& fixture, Duration settle) {
  const auto run = [&](Duration time) {
    const TimePoint end = fixture.clock.now() + time;
    while (fixture.clock.now() < end && fixture.step())
      if (!fixture.printer.light_is_on()) return;
  };
  run(settle);
  const Nanometers from = fixture.printer.z_axis().height().value();
  const TimePoint then = fixture.clock.now();
  run(10s);
  REQUIRE(fixture.printer.light_is_on());
  return in_mm(fixture.printer.z_axis().height().value() - from) * 3600 /
         in_seconds(fixture.clock.now() - then);
}

// The grey value of half of the light.
const int kHalf = white_for(50, 1);

int brightest(const ContinuousPrintFixture& fixture) {
  return std::ranges::max(fixture.screen.on_screen.value().pixels());
}

}  // namespace

TEST_CASE("A rise can be changed every three seconds, since each change stops the plate in the light") {
  ContinuousPrintFixture fixture;
  fixture.compares = false;
  fixture.process.start(changeable_plan());
  REQUIRE(fixture.run_to_height(0.2));
  CHECK(fixture.process.why_fixed("speed").empty());
  RiseSettings settings = fixture.process.settings().rise;
  settings.speed_mm_h = 30;
  REQUIRE(change(fixture, settings) == "");
  CHECK(testing::lacking(std::string(fixture.process.why_fixed("margin")), {"try again in three seconds"}) ==
        "");
  (void)speed_after(fixture, 3s);
  CHECK(fixture.process.why_fixed("margin").empty());
}

TEST_CASE("A slower rise is refused by the light so far and what is left, not by that of the whole rise") {
  PrintPlan plan = changeable_plan();
  plan.rises->bounds.window = std::chrono::seconds{250};
  ContinuousPrintFixture fixture;
  fixture.compares = false;
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to_height(0.2));
  RiseSettings slower = fixture.process.settings().rise;
  slower.speed_mm_h = 10;
  CHECK(testing::lacking(change(fixture, slower), {"for 319", "lasts for 250"}) ==
        "");  // 18 s, 0.8 mm in 288, and the gap of 37 um in 13
  REQUIRE(fixture.run_to_height(0.7));
  CHECK(change(fixture, slower) == "");  // 108 s, and 0.3 mm in 108
  slower.speed_mm_h = 5;
  (void)speed_after(fixture, 3s);
  CHECK(testing::lacking(change(fixture, slower), {"lasts for 250"}) == "");
}

TEST_CASE("Speed, light and margin of a rise change while the plate rises, in the light") {
  ContinuousPrintFixture fixture;
  fixture.compares = false;
  PrintPlan plan = changeable_plan();
  fixture.front.emplace(plan.rises->bounds.lit, Nanometers{100'000}, kMasks);
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to_height(0.2));
  CHECK(speed_after(fixture, 0s) == Approx(20).margin(0.5));
  RiseSettings settings = fixture.process.settings().rise;

  settings.speed_mm_h = 300;
  REQUIRE(change(fixture, settings) == "");
  CHECK(fixture.process.settings().rise == settings);
  CHECK(speed_after(fixture, 1s) == Approx(55.26).margin(0.5));
  CHECK(std::ranges::count(fixture.states, "slowing") == 1);

  settings.light_percent = 50;
  REQUIRE(change(fixture, settings) == "");
  CHECK(speed_after(fixture, 1s) == Approx(55.26 * kHalf / 255).margin(0.5));
  CHECK(brightest(fixture) == kHalf);

  settings.margin = 8;
  REQUIRE(change(fixture, settings) == "");
  CHECK(speed_after(fixture, 1s) == Approx(55.26 * kHalf / 255 / 2).margin(0.5));

  settings.light_percent = 100;
  settings.speed_mm_h = 10;
  REQUIRE(change(fixture, settings) == "");
  CHECK(speed_after(fixture, 1s) == Approx(10).margin(0.5));
  CHECK(brightest(fixture) == 255);
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.interruptions.empty());
  CHECK(fixture.dangers() == "");
  CHECK(std::ranges::count(fixture.states, "darkening") == kFirstLayers + 1);  // and at the rise's end
  CHECK(frame_figures(fixture.layers).missed == 0);
  // The masks' light is on record.
  std::set<int> lights;
  for (const FrameRecord& frame : fixture.recorded)
    lights.insert(frame.light);
  CHECK(lights == std::set{kHalf, 255});
  CHECK(std::ranges::count(fixture.recorded, kHalf, &FrameRecord::light) > 5);
  CHECK(std::ranges::count(fixture.recorded, 255, &FrameRecord::light) > 50);
}

TEST_CASE("More light is on the screen before the plate rises faster by it") {
  ContinuousPrintFixture fixture;
  fixture.compares = false;
  PrintPlan plan = changeable_plan();
  plan.rises->settings.speed_mm_h = 300;
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to_height(0.2));
  RiseSettings settings = fixture.process.settings().rise;
  settings.light_percent = 30;
  REQUIRE(change(fixture, settings) == "");
  (void)speed_after(fixture, 1s);
  settings.light_percent = 90;
  REQUIRE(change(fixture, settings) == "");
  REQUIRE(fixture.run_to(C::Slowing));
  CHECK(brightest(fixture) == std::lround(255 * 0.9));
}

TEST_CASE("The time left follows a change of the speed, which also holds for rises that come later") {
  ContinuousPrintFixture fixture;
  fixture.compares = false;
  PrintPlan plan = changeable_plan();
  fixture.front.emplace(plan.rises->bounds.lit, Nanometers{100'000}, kMasks);
  fixture.process.start(std::move(plan));
  SECTION("In the first layers") {
    REQUIRE(fixture.run_to(C::Layering));
    while (fixture.process.state().name != "exposing")
      REQUIRE(fixture.step());
  }
  SECTION("On the way down to the rise") {
    REQUIRE(fixture.run_to(C::Lowering));
  }
  SECTION("Within the rise") {
    REQUIRE(fixture.run_to_height(0.15));
  }
  SECTION("In a pause within the rise") {
    REQUIRE(fixture.run_to_height(0.15));
    fixture.process.pause();
    REQUIRE(fixture.run_to(C::Paused));
  }
  const Duration before = fixture.process.time_left();
  RiseSettings settings = fixture.process.settings().rise;
  settings.speed_mm_h = 10;
  REQUIRE(change(fixture, settings) == "");
  const bool rises = fixture.process.continuous_state() == C::Rising;
  if (rises) REQUIRE(fixture.run_to(C::Slowing));
  if (rises) REQUIRE(fixture.run_to(C::Rising));
  CHECK(in_seconds(fixture.process.time_left() - before) ==
        Approx(0.9 * 3600 / 20).margin(10));  // with the gaps
  if (fixture.process.continuous_state() == C::Paused) fixture.process.resume();
  REQUIRE(fixture.run_to_height(0.3));
  CHECK(speed_after(fixture, 0s) == Approx(10).margin(0.5));
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.dangers() == "");
}

TEST_CASE("Settings with which a rise is too slow or too long, and prints without a rise, change nothing") {
  ContinuousPrintFixture fixture;
  fixture.process.start(changeable_plan());
  REQUIRE(fixture.run_to_height(0.2));
  const RiseSettings settings = fixture.process.settings().rise;
  RiseSettings other = settings;
  other.margin = 50;
  CHECK(testing::lacking(change(fixture, other), {"margin 50", "4.4", "least_speed_mm_h is 5"}) == "");
  other.margin = 1;
  CHECK(testing::lacking(change(fixture, other), {"a margin above 1"}) == "");
  other = settings;
  other.light_percent = 0;
  CHECK(testing::lacking(change(fixture, other), {"a light 1 to 100 %"}) == "");
  CHECK(fixture.process.settings().rise == settings);
  CHECK(fixture.process.why_fixed("speed").empty());
  CHECK(speed_after(fixture, 0s) == Approx(20).margin(0.5));
  REQUIRE(fixture.run_to(C::Parking));
  CHECK(testing::lacking(std::string(fixture.process.why_fixed("light")), {"no rise follows"}) == "");
  CHECK(change(fixture, settings) == "no rise is left");
  fixture.run_out();
  CHECK(std::ranges::count(fixture.states, "slowing") == 0);

  ContinuousPrintFixture layered;
  layered.process.start(testing::box_plan(2));
  CHECK(testing::lacking(std::string(layered.process.why_fixed("margin")), {"does not rise"}) == "");
}

TEST_CASE("A change within a rise that would outlast the window's oxygen is refused") {
  ContinuousPrintFixture fixture;
  PrintPlan plan = changeable_plan();
  plan.rises->bounds.window = std::chrono::minutes{4};
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to_height(0.2));
  RiseSettings settings = fixture.process.settings().rise;
  settings.speed_mm_h = 10;
  CHECK(testing::lacking(change(fixture, settings), {"0.10 to 1.00 mm", "oxygen", "240", "window_s"}) == "");
}

TEST_CASE("Resistance on the way down to a rise pauses the print in the dark, and it goes on without it") {
  for (const bool fails : {false, true}) {
    SimulatedPrinterConfig config = testing::small_printer();
    config.axis.force =
        SimulatedForceConfig{.obstruction = Nanometers{3'000'000}, .obstruction_after_lifts = kFirstLayers};
    ContinuousPrintFixture fixture(cone_engine(), config);
    PrintPlan plan = cone_plan();
    plan.force = ForcePolicy{.contact_from = Nanometers{2'000'000}, .resistance_fails = fails};
    fixture.process.start(std::move(plan));
    REQUIRE(fixture.run_to(C::Lowering));
    CHECK(fixture.run_to(C::Paused) != fails);
    if (!fails) {
      REQUIRE(fixture.interruptions.size() == 1);
      CHECK(fixture.interruptions[0].starts_with(
          "the plate met resistance at 3.100 mm on its way down to 0.100 mm, where force is expected only "
          "below 2.100 mm: "));
      fixture.process.resume();
      fixture.run_out();
    }
    CHECK(fixture.ends == std::vector{fails ? PrintOutcome::Failed : PrintOutcome::Done});
    CHECK(fixture.dangers().empty());
  }
}

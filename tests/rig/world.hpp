// A simulated printer: the real print process on a machine of models, a user, and everything that goes wrong.
// Not thread-safe.
#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/print/continuous_print.hpp"
#include "daemon/print/layered_print.hpp"
#include "tests/rig/machine_model.hpp"
#include "tests/rig/scenario.hpp"
#include "tests/rig/verdict.hpp"

namespace contourd::rig {

class World final : private PrintObserver {
 public:
  explicit World(const Scenario& scenario);

  // Runs all prints, then gives pending actions time to end.
  void run();

  [[nodiscard]] const Verdict& verdict() const { return verdict_; }
  // The log of events, a line each; empty unless keep_story() was called.
  [[nodiscard]] const std::vector<std::string>& story() const { return story_; }
  void keep_story();

 private:
  void light_due() override {}
  void state_changed(const PrintState& state) override;
  void layer_done(const LayerRecord& layer) override;
  void interrupted(const std::string& what) override;
  void light_gone() override {}
  void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) override;

  [[nodiscard]] PrintPlan plan() const;
  [[nodiscard]] PlannedRises rises() const;
  [[nodiscard]] bool is_in(std::initializer_list<std::string_view> states) const;
  [[nodiscard]] bool rising() const;
  void change_rises();
  [[nodiscard]] bool print_all();
  [[nodiscard]] bool run_until(const std::function<bool()>& done, Duration longest);
  void step();
  void look();
  void look_at_motion();
  void look_at_force();
  void happen(const Happening& happening);
  void press(AxisInput input, const Happening& happening);
  void expect_dark_soon();
  void tend();
  void tell(const std::string& what);
  // Returns the number of a layer, or of all of a print's rise.
  [[nodiscard]] int number() const { return print_ * 1000 + (rising() ? kRise : process_->layer()); }

  static constexpr int kRise = 900;

  const Scenario scenario_;
  Dice user_, encoder_;
  MachineModel machine_;
  Verdict verdict_;
  std::unique_ptr<PrintMode> process_;
  const ContinuousPrint* continuous_ = nullptr;  // process_, if it rises; otherwise null
  int print_ = 0, states_ = 0;
  std::vector<std::unique_ptr<Timer>> timers_;
  std::unique_ptr<Timer> user_timer_;
  std::optional<std::int64_t> stopped_at_;  // motor position when the stop was requested
  std::optional<std::int64_t> pressed_at_;  // the motor's highest position under a force that is resistance
  TimePoint encoder_loses_until_{}, encoder_loses_upwards_until_{};
  bool ending_ = false;
  TimePoint ending_since_{};  // start of the last state that waits only for darkness
  bool keeps_story_ = false;
  std::vector<std::string> story_;
};

}  // namespace contourd::rig

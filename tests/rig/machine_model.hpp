// The machine of a simulated printer: the daemon's own axis, projector and light line on models of the
// hardware. It loses devices and finds them again as RealMachine does. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hw/absent_devices.hpp"
#include "hw/gpio/gpio_light_line.hpp"
#include "hw/machine.hpp"
#include "hw/serial/serial_projector.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/rig/display_model.hpp"
#include "tests/rig/loop.hpp"
#include "tests/rig/projector_model.hpp"
#include "tests/rig/scenario.hpp"

namespace contourd::rig {

class MachineModel final : public Machine {
 public:
  explicit MachineModel(const Scenario& scenario);
  ~MachineModel() override;

  [[nodiscard]] ZAxis& z_axis() override { return axis_; }
  [[nodiscard]] MaskDisplay& display() override { return screen; }
  [[nodiscard]] Projector& projector() override { return light_; }
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  [[nodiscard]] std::string why_not_ready() const override;
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  // Called before a request is passed to the devices.
  std::function<void(Duration exposure)> light_asked = [](Duration) {};
  std::function<void()> light_unasked = [] {};
  std::function<void()> stop_asked = [] {};  // called when motion is to end
  std::function<void()> move_asked = [] {};

  // Called when the light or the screen has changed.
  std::function<void()> changed = [] {};

  // Sets a callback for messages on the serial line, for the log.
  void on_message(std::function<void(const std::string&)> call) { model_->tell = std::move(call); }

  // Happenings.
  void unplug_adapter(Duration time);
  void lose_display(Duration time);
  // Keeps the light line's state for that time.
  void refuse_line(Duration time);
  void hold_up_next_write(Duration time) { write_takes_ = time; }
  // Makes everything work from now on.
  void heal();

  // True if the machine reports that the light may be on, or cannot know better yet, since a projector that
  // was just found has not answered.
  [[nodiscard]] bool light_off_unconfirmed() const;

  // True if the projector may be lit, switches its light by commands and can be reached: as long as no light
  // is wanted, light off is to be sent again and again.
  [[nodiscard]] bool light_off_due() const;
  // Returns the longest time between two of these light offs; a power off counts too.
  [[nodiscard]] Duration longest_light_off_pause() const;

  // The true state.
  [[nodiscard]] bool lit() const;
  [[nodiscard]] bool stray() const { return kind_ == LightKind::Serial && model_->came_up_lit(); }
  [[nodiscard]] bool lamp_is_on() const { return serial_ && model_->powered(); }
  [[nodiscard]] Nanometers plate() const;
  // Returns the height up to which a force on the plate is normal.
  [[nodiscard]] Nanometers normal_force_up_to() const { return contact_ + kContactFrom; }
  [[nodiscard]] std::uint64_t line_faults() const { return model_->faults_made(); }
  [[nodiscard]] TimePoint off_sent() const { return model_->off_sent(); }

  // Runs the next event of the world.
  void turn();

  testing::Plant plant;
  Loop loop;
  DisplayModel screen;

 private:
  // Passes calls to the present projector, which may be lost and found again.
  class NotedProjector final : public testing::PlainProjector {
   public:
    explicit NotedProjector(MachineModel& machine) : machine_(machine) {}
    void power_on(Done done) override { now().power_on(std::move(done)); }
    void light_on(Duration exposure, LightOn tell) override {
      machine_.light_asked(exposure);
      now().light_on(exposure, std::move(tell));
    }
    void light_off() noexcept override {
      machine_.light_unasked();
      now().light_off();
    }
    void when_dark(std::function<void()> call) override { now().when_dark(std::move(call)); }
    [[nodiscard]] std::optional<LightSpan> last_light() const override { return now().last_light(); }
    void power_off() noexcept override { now().power_off(); }
    void ask_status(StatusDone done) override { now().ask_status(std::move(done)); }
    [[nodiscard]] std::string last_problem() const override { return now().last_problem(); }
    [[nodiscard]] std::string light_off_unconfirmed() const override { return now().light_off_unconfirmed(); }

   private:
    [[nodiscard]] Projector& now() const { return machine_.present_projector(); }
    MachineModel& machine_;
  };
  class NotedAxis final : public testing::PlainAxis {
   public:
    explicit NotedAxis(MachineModel& machine) : machine_(machine) {}
    void home(std::function<void(HomingResult)> done) override {
      machine_.move_asked();
      machine_.contact_ = {};
      now().home(std::move(done));
    }
    void move_to(Nanometers target, MillimetersPerSecond speed,
                 std::function<void(MoveResult)> done) override {
      machine_.move_asked();
      now().move_to(target, speed, std::move(done));
    }
    void expect_contact_at(Nanometers height) override {
      machine_.contact_ = height;
      now().expect_contact_at(height);
    }
    [[nodiscard]] std::optional<bool> force() const override { return now().force(); }
    void on_force(std::function<void(const ForceChange&)> call) override { now().on_force(std::move(call)); }
    void stop() override {
      machine_.stop_asked();
      now().stop();
    }
    void abort() noexcept override {
      machine_.stop_asked();
      now().abort();
    }
    [[nodiscard]] bool moving() const override { return now().moving(); }
    [[nodiscard]] std::optional<Nanometers> height() const override { return now().height(); }
    [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override {
      return now().height_at(time);
    }
    [[nodiscard]] Nanometers travel() const override { return now().travel(); }
    void rise(const RisePlan& plan, std::function<void(MoveResult)> done) override {
      machine_.move_asked();
      now().rise(plan, std::move(done));
    }
    [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
      return now().move_duration(distance, speed);
    }
    [[nodiscard]] std::vector<AxisInputState> inputs() const override { return now().inputs(); }
    [[nodiscard]] LateSteps late_steps() const override { return now().late_steps(); }

   private:
    [[nodiscard]] GpioAxis& now() const { return *machine_.plant.axis; }
    MachineModel& machine_;
  };

  [[nodiscard]] Projector& present_projector();
  void open_adapter();
  void open_line();
  void combine();
  void search();
  void tell(const MachineEvent& event);

  static constexpr Nanometers kContactFrom{300'000};

  const LightKind kind_;
  Nanometers contact_{};
  const ProjectorTable table_;
  std::function<void(const MachineEvent&)> on_event_;
  NotedProjector light_;
  NotedAxis axis_;
  AbsentProjector no_projector_;
  std::unique_ptr<ProjectorModel> model_;
  bool adapter_there_ = true, line_level_ = false, line_refuses_ = false;
  Duration write_takes_{};
  TimePoint found_at_{};
  bool heard_ = false;  // true if the projector has answered since it was found
  testing::PlantOutput* output_ = nullptr;
  AbsentLightLine no_line_;
  std::unique_ptr<Timer> search_, plug_, screen_timer_, line_timer_;
  std::unique_ptr<GpioLightLine> line_;
  std::shared_ptr<LineEnd> port_;
  std::unique_ptr<SerialProjector> serial_;
  std::unique_ptr<Projector> combined_;
};

}  // namespace contourd::rig

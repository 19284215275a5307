// The printer: takes jobs from the spool, one after the other, has them prepared, prints them, and files what
// came of it. Answers for the control socket. Event loop's thread only.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/control_server.hpp"
#include "daemon/job_settings.hpp"
#include "daemon/log.hpp"
#include "daemon/print_analyst.hpp"
#include "daemon/print_archivist.hpp"
#include "daemon/print_process.hpp"
#include "daemon/print_report.hpp"
#include "daemon/reading_record.hpp"
#include "daemon/spool.hpp"
#include "daemon/supervisor.hpp"
#include "daemon/worker.hpp"

namespace contourd {

class PrinterService final : private SpoolObserver, private PrintObserver {
 public:
  using Json = ControlServer::Json;

  // All must outlive the service.
  PrinterService(const PrinterConfig& config, EventLoop& loop, Clock& clock, Machine& machine, const Log& log,
                 Supervisor& supervisor);
  ~PrinterService() override;

  // Files interrupted prints, opens the spool and the socket: after this, jobs are taken. Throws
  // std::runtime_error.
  void start();

  // Ends a print under way (light off, its files to failed/), takes no more jobs, and stops the loop when the
  // light is off and the print filed, or after some seconds.
  void shut_down(const std::string& reason);

  // Something happened to the machine, or is about to.
  void disturbed(const Disturbance& disturbance);

  // `call` gets true when a print begins, and false when none is under way any more; also again.
  void on_printing(std::function<void(bool)> call) { printing_ = std::move(call); }

 private:
  struct QueuedJob {
    std::string file;  // in incoming/
    TimePoint arrived;
    enum class Check {
      Wanted,
      Running,
      Passed,
      Postponed,  // there is no room for it in memory beside what is there now
      Refused,    // on its way to failed/
    } check = Check::Wanted;
    bool withdrawn = false;   // on its way to failed/ it went, by the owner's hand or by the spool's
    std::string postponed{};  // why, already told; empty when it was not
    bool waited = false;      // for another print, or for the plate
    std::string trouble;      // why it could not be claimed, already told
    // Read when its turn comes; nothing where its ticket is a reason to refuse it.
    std::optional<JobSettings> settings{};
  };
  // The job between its claim and its end.
  struct ActiveJob {
    JobFiles files;
    TimePoint turn_came;                  // when it arrived, or its waiting ended; CLOCK_MONOTONIC
    std::optional<PreparedJob> prepared;  // nothing while it is being prepared; its plan moves to the process
    std::vector<LayerRecord> layers;
    std::vector<std::string> interruptions;
    TimePoint started;              // machine's clock
    std::uint64_t late_steps_then;  // of the axis
    std::chrono::system_clock::time_point started_at;
    std::optional<std::filesystem::path> masks;
    Json analysis;               // the findings in short, for whoever asks; null while there are none
    bool cancel_wanted = false;  // cancelled before it could start
    int readings = 0;            // that found no room in memory
    std::optional<JobSettings> settings{};
    std::optional<PrintFindings> findings;  // nothing while the analysis is under way
    std::optional<EndedPrint> over;         // once the print is, until its analysis is too
    EventLoop::Turn busiest_lit{};          // of those while there was or may have been light
  };
  // Left in printing/ by a contourd that did not file it.
  struct LeftJob {
    JobFiles files;
    std::optional<PrintEnd> end;  // nothing when its print did not come to one
  };
  struct Refusal {
    std::string reason;
    bool for_now = false;   // there may be room in memory for it later
    std::string profile{};  // what is the matter with its resin's, which is no reason to refuse it
  };
  struct EndedJob {
    std::string name, outcome, reason;
    Json analysis;  // in short; null when there is none
  };

  void model_arrived(const std::string& file) override;
  void model_withdrawn(const std::string& file) override;
  void plate_waits(const std::string& file, const std::vector<std::string>& missing) override;
  void passed_over(const std::string& file, Oddity oddity) override;
  void more_passed_over(std::size_t files) override;
  void incoming_lost(const std::string& why) override;
  void incoming_replaced() override;
  void state_changed(PrintState state) override;
  void layer_done(const LayerRecord& layer) override;
  void warn_about_light(const LayerRecord& layer, const LogFields& fields);
  void interrupted(const std::string& what) override;
  void light_gone() override;
  void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) override;

  // Keeps the longest, for the report.
  void note_lit_turn(const EventLoop::Turn& turn);
  // Jobs left in printing/ by a contourd that did not end them: they hold the queue, and go to failed/. Those
  // that it only did not file any more go where they belong.
  void find_left_jobs();
  // Throws std::system_error; the rest of them stays where it is.
  void file_left_jobs();
  void leave_if_over();
  void stop_waiting_for_filing();
  void give_back_unbegun();
  // Does what is due: starts the next job, or has a waiting one checked. Never from inside the print process.
  void pump();
  void pump_soon();
  void retry_later();
  void take_what_is_due();
  [[nodiscard]] std::string reason_to_wait() const;
  // For the service manager's status line.
  [[nodiscard]] std::string readiness() const;
  void begin_next();
  // Throws ProfileTrouble when the queue has to wait for the profile.
  [[nodiscard]] std::optional<JobSettings> settings_of(const QueuedJob& job) const;
  void wait_for_profile(QueuedJob job, const std::string& why);
  // Has it printed, for which nothing is in the way any more.
  void claimed(QueuedJob job, JobFiles files);
  void not_claimed(QueuedJob job, const std::system_error& error);
  // What cannot be moved is copied, or refused if that cannot be either.
  void begin_with_copy(QueuedJob job, const std::string& why);
  void copied(const Spool::Copy& copy, const std::string& why);
  void check_waiting();
  // On the worker's thread.
  [[nodiscard]] std::variant<PreparedJob, Refusal> read(const JobFiles& files,
                                                        const std::optional<JobSettings>& settings);
  void read_active();
  // Whether the active job is read again, since that found no room in memory that there may be soon.
  [[nodiscard]] bool read_later(const Refusal& refusal);
  void prepared(std::variant<PreparedJob, Refusal> result);
  void checked(const std::string& file, const std::optional<Refusal>& refusal);
  void postpone(QueuedJob& job, const std::string& why);
  // Those have their check again for which there was no room: some memory may be free by now.
  void check_postponed();
  void remove_withdrawn(std::deque<QueuedJob>::iterator job);
  void reject(QueuedJob& job, const std::string& reason);
  void rejected(const std::string& file, const std::string& reason, Spool::Rejection rejection,
                const std::string& trouble);
  void start_print();
  void start_analysis();
  void analyzed(AnalyzedPrint print);
  // Has the print that is over filed, with its report.
  void finish_job();
  void filed(const FiledPrint& print);
  void file_job(const JobFiles& files, Spool::Folder to, const std::string& reason);
  // The same, but throws std::system_error when it stays in printing/.
  void move_job(const JobFiles& files, Spool::Folder to, const std::string& reason);
  [[nodiscard]] std::uint64_t late_steps_of_job() const;
  // Takes what the job knows of itself.
  [[nodiscard]] PrintReport make_report(PrintOutcome outcome, const std::string& reason);
  void warn_about_lateness(const PrintReport& report);
  void ended(const std::string& name, std::string_view outcome, const std::string& reason,
             Json analysis = {});
  void notify(const std::string& what, ControlServer::Delivery delivery);
  void set_plate_occupant(const std::optional<std::string>& job);
  // No job begins from now on until the owner has spoken, whatever the plate holds.
  void hold(const std::string& why);
  void let_go();
  // That it is held, why, and what the owner is to do; empty when it is not.
  [[nodiscard]] std::string hold_sentence() const;
  // Has the disk know what the plate holds and whether the queue is held, for the next start: in the dark,
  // the disk may take its time. What it does not take now is tried again.
  void keep_records();

  [[nodiscard]] std::map<std::string, ControlServer::Method> methods();
  // Logs who gave a command; whoever only asks is not told of.
  void called(const std::string& method, const ControlServer::Peer& peer) const;
  [[nodiscard]] Json status() const;
  [[nodiscard]] Json job_json() const;
  [[nodiscard]] static Json ended_json(const EndedJob& job);
  Json cancel();
  Json resume_queue();
  void require_print(std::string_view what) const;
  // REQUIRES: a print that is not idle, and can be neither paused nor, when it is over, cancelled.
  [[nodiscard]] std::string why_it_ends() const;
  // The print is over, its job not filed yet.
  [[nodiscard]] bool finishing() const;

  const PrinterConfig& config_;
  EventLoop& loop_;
  Clock& clock_;
  Machine& machine_;
  const Log& log_;
  Supervisor& supervisor_;
  Spool spool_;
  ReadingRecord reading_record_;
  PrintProcess process_;
  std::deque<QueuedJob> queue_;
  int rejections_ = 0;                // under way
  std::optional<QueuedJob> copying_;  // whose turn it is
  std::optional<ActiveJob> active_;
  std::deque<EndedJob> ended_;  // the latest last
  std::optional<std::string> plate_occupant_;
  std::optional<std::string> held_;  // why
  std::vector<LeftJob> left_jobs_;   // not filed yet
  std::string unkept_;               // why the disk does not know all of these; empty when it does
  bool records_due_ = false;         // as soon as it is dark
  std::string waiting_for_;          // why the next job does not start, already told
  bool shutting_down_ = false;
  std::function<void(bool)> printing_;
  std::unique_ptr<ControlServer> control_;
  EventLoop::SourcePtr pump_timer_, keep_timer_, leave_timer_, read_timer_;
  PrintAnalyst analyst_;
  PrintArchivist archivist_;
  Worker worker_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd

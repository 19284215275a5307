// Records that survive a restart of the daemon, one file each in its state folder. The folder is private to
// the daemon: users who may put models into the spool can neither read nor write it.
//
//   plate-occupied   one line: the name of the job whose part is on the plate
//   queue-held       one line: why no job begins until a user confirms it
//   ended-jobs       how jobs have ended, until all of contourd knows (job_ends.hpp): fields, each followed
//                    by a zero byte
//   ended-jobs.spare-1, ended-jobs.spare-2
//                    room for ended-jobs on a full disk: blanks, which are overwritten before the rename
//   claim            the job that was moved to printing/ last under another name: fields as in ended-jobs
//   queue-order      the waiting jobs in an order that a user has set: file names in incoming/, each followed
//                    by a zero byte
//   vat              one line: the resin in the vat, in ml
//   print-progress   how far the print under way is (daemon/progress/progress_record.hpp)
//   print-frames     the masks that the rise under way has shown (daemon/frames/frame_file.hpp)
//   accepted         the findings that users have accepted, one line each (acceptances.hpp)
//
// A setter syncs the record to the disk before it returns, and does not write a line that is unchanged.
// Thread-safe for different records (no shared state). Setters throw std::system_error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace contourd {

// Returns the service manager's folder (STATE_DIRECTORY, systemd.exec(5)), or SPOOL.state beside the spool.
[[nodiscard]] std::filesystem::path state_folder_path(const std::filesystem::path& spool);

// Returns the record of the print under way in the state folder of this spool.
[[nodiscard]] std::filesystem::path progress_file(const std::filesystem::path& spool);
// Returns the file of the frames of the print under way.
[[nodiscard]] std::filesystem::path frames_file(const std::filesystem::path& spool);

// Makes the folder if it does not exist, and removes all permissions of other users. Throws
// std::runtime_error if the folder cannot be made or belongs to another user.
void make_state_folder(const std::filesystem::path& folder);

class StateRecords {
 public:
  explicit StateRecords(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Returns the job whose part is on the plate, or nullopt if the plate is clear.
  [[nodiscard]] std::optional<std::string> plate_occupant() const;
  void set_plate_occupant(const std::optional<std::string>& job) const;

  // Returns why no job may begin until a user confirms it, or nullopt.
  [[nodiscard]] std::optional<std::string> hold() const;
  void set_hold(const std::optional<std::string>& why) const;

  // Returns the text that was kept last about the resin in the vat, or nullopt.
  [[nodiscard]] std::optional<std::string> vat() const;
  void set_vat(const std::string& ml) const;

  // The file in incoming/, the model's name in printing/ and the mark of the last job that was claimed under
  // another name.
  [[nodiscard]] std::vector<std::string> claim() const;
  void keep_claim(const std::vector<std::string>& fields) const;

  // The fields of JobEndRecord. On a full disk they are written over a spare, and the record before becomes
  // one.
  [[nodiscard]] std::vector<std::string> job_ends() const;
  void keep_job_ends(const std::vector<std::string>& fields) const;
  // Makes the spares that do not exist, as far as the disk has room: one for the end of a print, one for the
  // notice of it.
  void make_spares() const;

  // Returns the next job first; empty if the order is that of arrival.
  [[nodiscard]] std::vector<std::string> queue_order() const;
  void keep_queue_order(const std::vector<std::string>& files) const;

  [[nodiscard]] std::vector<std::string> accepted() const;
  void keep_accepted(const std::vector<std::string>& lines) const;

 private:
  [[nodiscard]] std::optional<std::string> first_line_of(const char* file) const;
  void keep_line(const char* file, const std::optional<std::string>& line) const;
  [[nodiscard]] std::vector<std::string> texts_of(const char* file, char end) const;
  void keep_texts(const char* file, const std::vector<std::string>& texts, char end) const;
  // Writes the text over a spare, which becomes ended-jobs. Returns false if that fails.
  [[nodiscard]] bool write_over_spare(const std::string& text) const;

  std::filesystem::path folder_;
};

}  // namespace contourd

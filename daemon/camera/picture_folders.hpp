// The folders with the pictures that the user's camera has taken of prints:
//
//   spool/pictures/JOB/        pictures of the print under way, which only contourd may write
//   spool/done/JOB.pictures/   pictures of a print that has ended, beside its files; or in failed/
//
// A picture is named by its layer, from 1: 00012.jpg. The film that a command has made of them is
// time-lapse.mp4. Thread-safe (immutable); blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/spool/spool_folders.hpp"

namespace contourd {

class PictureFolders {
 public:
  static constexpr const char* kSuffix = ".pictures";

  explicit PictureFolders(const std::filesystem::path& spool) : folders_(spool) {}

  // Returns the folder of a job's pictures; empty if there is none. REQUIRES: no '/' in the job's name.
  [[nodiscard]] std::filesystem::path find(const std::string& job) const;
  // Returns the folder of the pictures of a print under way, which need not exist.
  [[nodiscard]] std::filesystem::path current(const std::string& job) const;
  // Makes that folder. Throws std::system_error.
  void make(const std::string& job) const;

  // Moves the pictures of jobs that are no longer in printing/ beside the job's files, and removes those of
  // jobs of which nothing is left. Throws std::system_error.
  void tidy() const;

 private:
  void file_away(const std::filesystem::path& pictures) const;
  [[nodiscard]] bool is_printing(const std::string& job) const;

  SpoolFolders folders_;
};

// The pictures in a folder.
struct StoredPictures {
  std::vector<std::int32_t> layers;  // from 0, in rising order
  std::uintmax_t bytes = 0;
};
// Returns the pictures in the folder, at most 10,000; none if it cannot be read.
[[nodiscard]] StoredPictures pictures_in(const std::filesystem::path& folder);

// Returns the path of a layer's picture, and of the film, in a folder.
[[nodiscard]] std::filesystem::path picture_file(const std::filesystem::path& folder, std::int32_t layer);
[[nodiscard]] std::filesystem::path film_file(const std::filesystem::path& folder);

}  // namespace contourd

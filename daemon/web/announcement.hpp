// The page's addresses for people: its URLs, and the file from which avahi-daemon announces the page in the
// local network by mDNS. Thread-safe (no state).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace contourd::web {

inline constexpr const char* kDefaultAnnouncement = "/etc/avahi/services/contourd.service";

// Returns the URLs at which other computers reach a page that listens on these ADDRESS:PORT. An address for
// all interfaces is named by this computer's name in .local; one of the loopback has no URL.
[[nodiscard]] std::vector<std::string> pages_at(const std::vector<std::string>& addresses);

// Returns the text of avahi's file for these ADDRESS:PORT; empty if only this computer can open the page.
[[nodiscard]] std::string announcement_of(const std::vector<std::string>& addresses);
// Writes the file, or removes it if there is nothing to announce. Blocks until it is on the disk. Throws
// OutputError with a sentence.
void announce(const std::vector<std::string>& addresses, const std::filesystem::path& file);

}  // namespace contourd::web

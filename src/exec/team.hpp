// SPDX-License-Identifier: Apache-2.0
// Threads that help a thread of the host with its loops.
#pragma once

#include <cstdint>
#include <thread>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {

/// The helper threads of one host thread: created at first use, asleep while idle, ended with that
/// thread. Not OpenMP, for three reasons: a caller does not wait for helpers that got no processor before the work was
/// done, so a busy machine never makes many threads slower than one; helpers sleep soon whatever the host's environment
/// says; and a thread that the system does not grant is done without, where OpenMP's runtime ends the process.
class Team {
 public:
  /// The work of every member. It may end before, or begin after, that of others: the work is complete when the members that
  /// have begun have returned, however few they are.
  using Work = void (*)(const void* data, int member);

  static Team& of_this_thread();

  /// work(data, 0) here and, beside it, work(data, m) on helpers m = 1 .. members-1 that find the time. Returns when all
  /// that began have returned. What they wrote is then visible here. `members` 1..max_members; less than 1 is 1.
  void run(int members, Work work, const void* data);

  static constexpr int max_members = 1024;

  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

 private:
  struct Shared;
  Team() = default;
  void grow(int members);
  void leave_behind();
  static void help(Shared& shared, int member);

  Shared* shared_ = nullptr;
  std::vector<std::thread> helpers_;
  bool refused_ = false;      ///< the system makes no more of them
  bool running_ = false;      ///< inside run(): work that calls run() again is done by its caller alone
  std::int64_t process_ = 0;  ///< that made the helpers: after a fork there are none
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim

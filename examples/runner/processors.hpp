// SPDX-License-Identifier: Apache-2.0
// The processors of this machine, and how threads wait for each other on them.
#pragma once

namespace runner {

/// Processors that this process may use, at least 1.
int processors();

/// Makes OpenMP's threads yield soon while they wait for each other. The default, to spin for about 10 ms, makes two
/// threads slower than one where another program uses a processor too. OpenMP reads this when it is loaded, so the
/// program starts itself anew, once. Returns when there is nothing to do: the user has set OMP_WAIT_POLICY or
/// GOMP_SPINCOUNT, or a new start is not possible.
void wait_politely(char** argv);

}  // namespace runner

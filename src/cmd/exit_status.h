// Exit statuses of all commands.
#pragma once

namespace lacquer::cmd {

enum class ExitStatus : int {
    Complete = 0,       ///< everything that was asked for is there
    Usage = 1,          ///< the command line makes no sense
    Scene = 2,          ///< the scene, or an asset it names, is wrong
    File = 3,           ///< a file cannot be read or written
    BadPixels = 4,      ///< rendered, but with more invalid samples than allowed
    NotConverged = 4,   ///< estimated, but chains or waves do not agree
    TimeLimit = 5,      ///< a valid image, but --spp was not reached within --time-limit
    Internal = 70,      ///< a bug of ours
    HungUp = 129,       ///< by SIGHUP, as where the terminal was closed; image written
    Interrupted = 130,  ///< by SIGINT; image written
    Terminated = 143,   ///< by SIGTERM; image written
};

}  // namespace lacquer::cmd

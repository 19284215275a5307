# Completion of contourctl in fish. Commands and options come from the program's --help; jobs and resins are the
# existing ones.

function __contourctl_commands
    contourctl $argv --help 2>/dev/null | sed -n '/^Subcommands:/,$ s/^  \([a-z-]*\)  *\(.*\)/\1\t\2/p'
end
function __contourctl_options
    set -l words (commandline -opc)
    if contains -- "$words[2]" motor light projector queue config
        contourctl $words[2] $words[3] --help 2>/dev/null | grep -oE '^ +(-[a-z],)?--[a-z,-]+' | grep -oE -- '--[a-z-]+'
        return
    end
    contourctl $words[2] --help 2>/dev/null | grep -oE '^ +(-[a-z],)?--[a-z,-]+' | grep -oE -- '--[a-z-]+'
end
function __contourctl_jobs
    contourctl status 2>/dev/null | sed -n 's/^job  *//p'
    __contourctl_waiting
end
function __contourctl_waiting
    contourctl queue 2>/dev/null | sed -n 's/^ *[0-9][0-9]*  \(.*\)\.[^.]*$/\1/p'
end
function __contourctl_asking
    contourctl queue 2>/dev/null | sed -nE '/^ *[0-9]+  /{s/^ *[0-9]+  (.*)\.[^.]*$/\1/;h}; /^     waits to be accepted/{x;p}'
end
function __contourctl_ended
    contourctl history --csv 2>/dev/null | sed -nE '1d; s/^"(([^"]|"")*)",.*/\1/; s/""/"/g; p' | sort -u
end
function __contourctl_models
    __fish_complete_suffix .stl
end
function __contourctl_queue_command
    set -l words (commandline -opc)
    test (count $words) -eq 3; and test "$words[2]" = queue
end
function __contourctl_resins
    for file in /etc/contourd/resins/*.json
        basename $file .json
    end
end
function __contourctl_before
    set -l words (commandline -opc)
    test "$words[-1]" = $argv[1]
end

complete -c contourctl -n __fish_use_subcommand -f -a '(__contourctl_commands)'
complete -c contourctl -n '__contourctl_before --job' -f -a '(__contourctl_jobs)'
complete -c contourctl -n '__contourctl_before --resin' -f -a '(__contourctl_resins)'
for group in motor light projector queue config
    complete -c contourctl -n "__contourctl_before $group" -f -a "(__contourctl_commands $group)"
end
complete -c contourctl -n '__contourctl_before preview' -f -a '(__contourctl_jobs) (__contourctl_ended) (__contourctl_models)'
complete -c contourctl -n '__contourctl_before accept' -f -a '(__contourctl_asking)'
complete -c contourctl -n '__contourctl_before logs' -f -a '(__contourctl_jobs)'
complete -c contourctl -n '__contourctl_before help' -f -a '(__contourctl_commands)'
complete -c contourctl -n __contourctl_queue_command -f -a '(__contourctl_waiting)'
complete -c contourctl -n '__contourctl_before show; and not __contourctl_queue_command' -a 'white black grid checker focus border dimensions'
complete -c contourctl -n '__contourctl_before replaced' -f -a 'lamp film vat'
complete -c contourctl -n '__contourctl_before schema' -f -a 'plate printer projector resin ticket'
complete -c contourctl -n '__contourctl_before --preset; or __contourctl_before --up' -f -a 'auto fast clean safe'
complete -c contourctl -n '__contourctl_before --aa' -f -a 'on off'
complete -c contourctl -n '__contourctl_before --outcome' -f -a 'done failed cancelled'
complete -c contourctl -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__contourctl_options)'

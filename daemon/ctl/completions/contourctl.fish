# Completion of contourctl in fish. The program itself prints the words; a line that begins with a slash stands for
# files with that suffix.

function __contourctl_words
    set -l words (commandline -opc)
    set -l word (commandline -ct)
    for line in (contourctl complete -- $words[2..] "$word" 2>/dev/null)
        switch $line
            case /
                __fish_complete_path "$word"
            case '/*'
                __fish_complete_suffix (string sub -s 2 -- $line)
            case '*'
                echo $line
        end
    end
end

complete -c contourctl -f -a '(__contourctl_words)'

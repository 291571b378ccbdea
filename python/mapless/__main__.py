from mapless._command import main

main()
